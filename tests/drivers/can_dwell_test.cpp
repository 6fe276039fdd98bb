// A whole dwell over a bus whose frames the kernel stamps by the wall clock, in virtual time: what the wall clock does
// to the coefficients.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "drivers/socketcan/bus.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/drivers/can_fake_socket.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

// The clocks of the computer in this test's time.
std::int64_t the_raw_ns = 0, the_real_ns = 0;
socketcan::ClockPair the_clocks() noexcept { return {the_raw_ns, the_real_ns, 100}; }

// What is done to the wall clock: from an instant on it runs `slew` faster, having been set by `step_ns`.
struct Adjustment {
  std::int64_t at_ns = 0;
  double slew = 0.0;
  std::int64_t step_ns = 0;
};

Chain three_masses() {
  Chain chain;
  chain.boundary = Boundary::clamped;
  chain.masses = {12, 8, 5};
  chain.stiffness = {24000, 8000, 6000, 8000};
  chain.damping = {60, 45, 30, 40};
  return chain;
}

// 40 s of the chain from rest, each channel a frame at 100 Hz, read every 5 to 20 ms.
Dwell measure(const std::vector<Adjustment>& adjustments, std::uint64_t* replaced) {
  const Chain chain = three_masses();
  const Rig rig = rig_of(chain, 4.0);
  Drive drive;
  drive.frequency_hz = 4.0;
  drive.amplitude = 0.005;
  DrivenChain motion(chain, drive, DrivenChain::Start::rest);
  Pipeline pipeline(rig);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<std::int64_t> pause_ns(5 * kMs_ns, 20 * kMs_ns);
  const std::int64_t begin_ns = 1000 * kSecond_ns;
  the_raw_ns = begin_ns;
  the_real_ns = 1'790'000'000 * kSecond_ns;
  test::FakeBus fake;
  socketcan::Bus bus("can0", fake.opener(), &the_clocks);
  EXPECT_EQ(bus.open(), "");
  double slew = 0.0;
  std::size_t adjusted = 0;
  const auto pass = [&](std::int64_t until_ns) {
    const auto run = [&](std::int64_t to_ns) {
      the_real_ns += to_ns - the_raw_ns + std::llround(slew * static_cast<double>(to_ns - the_raw_ns));
      the_raw_ns = to_ns;
    };
    for (; adjusted < adjustments.size() && begin_ns + adjustments[adjusted].at_ns <= until_ns; ++adjusted) {
      run(begin_ns + adjustments[adjusted].at_ns);
      slew = adjustments[adjusted].slew;
      the_real_ns += adjustments[adjusted].step_ns;
    }
    run(until_ns);
  };
  const auto channels = static_cast<canid_t>(rig.channels.size());
  std::int64_t next_read_ns = begin_ns;
  for (int frame = 0; frame < 4000; ++frame) {
    for (canid_t c = 0; c < channels; ++c) {
      const std::int64_t came_ns = begin_ns + frame * 10 * kMs_ns + c * kMs_ns;
      while (next_read_ns <= came_ns) {
        pass(next_read_ns);
        for (const socketcan::Frame& got : bus.read().frames) {
          Record record;
          record.t_ns = got.stamp.t_ns - begin_ns;
          record.t_half_ns = got.stamp.t_half_ns;
          std::memcpy(&record.value, got.can.data, sizeof record.value);
          record.channel = static_cast<std::uint16_t>(got.can.can_id);
          pipeline.push(record);
          *replaced += got.stamp.replaced ? 1 : 0;
        }
        next_read_ns += pause_ns(random);
      }
      pass(came_ns);
      const double exact =
          exact_reading(rig, motion.at(1e-9 * static_cast<double>(came_ns - begin_ns)), static_cast<int>(c));
      const double value = exact * (1 + 1e-3 * normal(random));
      socketcan::Packet packet;
      packet.frame.can_id = c;
      packet.frame.len = sizeof value;
      std::memcpy(packet.frame.data, &value, sizeof value);
      packet.size = CAN_MTU;
      packet.real_ns = the_real_ns;
      fake.arrive(packet);
    }
  }
  EXPECT_NE(pipeline.finish() & kCompleted, 0U);
  return pipeline.completed();
}

TEST(CanDwell, HasTheSameCoefficientsWhateverTheWallClockDoes) {
  std::uint64_t replaced = 0;
  const Dwell expected = measure({}, &replaced);
  ASSERT_EQ(expected.elements.size(), 4U);
  for (const std::vector<Adjustment>& adjustments :
       std::vector<std::vector<Adjustment>>{{{15'003 * kMs_ns, 0.0, kHour_ns}},
                                            {{15'003 * kMs_ns, 0.0, -kHour_ns}},
                                            {{10'000 * kMs_ns, 500e-6, 0}},
                                            {{10'000 * kMs_ns, -500e-6, 0}},
                                            {{10'001 * kMs_ns, 500e-6, kHour_ns},
                                             {20'007 * kMs_ns, -500e-6, -2 * kHour_ns},
                                             {30'004 * kMs_ns, 0.0, kHour_ns}}}) {
    const Dwell found = measure(adjustments, &replaced);
    ASSERT_EQ(found.elements.size(), 4U);
    for (std::size_t e = 0; e < 4; ++e) {
      ASSERT_TRUE(expected.elements[e].identifiable && found.elements[e].identifiable);
      const auto &c = expected.elements[e].stiffness, &r = expected.elements[e].damping;
      EXPECT_LE(std::abs(found.elements[e].stiffness.value - c.value), 0.1 * c.u) << "c_" << e + 1;
      EXPECT_LE(std::abs(found.elements[e].damping.value - r.value), 0.1 * r.u) << "r_" << e + 1;
    }
  }
  EXPECT_EQ(replaced, 0U);
}

}  // namespace
}  // namespace dwell
