#include "daemon/ctl/identify.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace dwell::ctl {
namespace {

constexpr double kStiffness = 240000.0;  // N/m
constexpr double kDamping = 310.0;       // N·s/m

Rig mount() {
  Rig rig;
  rig.boundary = Boundary::clamped;
  rig.excitation.frequency_hz = 4.0;
  rig.excitation.search_low_hz = 3.92;
  rig.excitation.search_high_hz = 4.08;
  rig.excitation.minimum = 2e-5;
  rig.channels.resize(2);
  Channel& y0 = rig.channels[0];
  y0.name = "y0";
  y0.unit = "mm";
  y0.si_per_unit = 1e-3;
  Channel& force = rig.channels[1];
  force.name = "force";
  force.measures = Quantity::force;
  force.at = kGround;
  return rig;
}

// 10 s of the mount at 4 Hz and 0.5 mm from first_s on, 200 samples per second and channel, the force 2 ms later.
CsvRecording recorded(double first_s, double amplitude_mm = 0.5) {
  constexpr double omega = 2.0 * std::numbers::pi * 4.0;
  const std::complex<double> Z{kStiffness, omega * kDamping};
  CsvRecording recording;
  recording.channels = {"y0", "force"};
  for (int i = 0; i < 2000; ++i) {
    const double t_s = i / 200.0;
    const double late_s = t_s + 0.002;
    recording.samples.push_back({first_s + t_s, amplitude_mm * std::sin(omega * t_s), 0});
    recording.samples.push_back(
        {first_s + late_s, 1e-3 * amplitude_mm * std::abs(Z) * std::sin(omega * late_s + std::arg(Z)), 1});
  }
  return recording;
}

TEST(Identify, FindsTheCoefficientsOfARecordingBegunInTheSteadyState) {
  const std::vector<Dwell> dwells = identify(mount(), recorded(0.0));
  ASSERT_EQ(dwells.size(), 1U);
  ASSERT_EQ(dwells[0].elements.size(), 1U);
  EXPECT_EQ(dwells[0].ended_by, EndedBy::end);
  EXPECT_NEAR(dwells[0].elements[0].stiffness.value, kStiffness, 1e-6 * kStiffness);
  EXPECT_NEAR(dwells[0].elements[0].damping.value, kDamping, 1e-5 * kDamping);
}

// Without noise: what the arithmetic loses is all that is left.
TEST(Identify, FindsTheSameFromAnyMotion) {
  const MotionEstimate motion = identify_motion(mount(), recorded(3.0));
  ASSERT_EQ(motion.reason, "");
  EXPECT_NEAR(motion.start_s, 3.0, 1e-9);
  ASSERT_TRUE(motion.elements.at(0).identifiable);
  EXPECT_NEAR(motion.elements[0].stiffness.value, kStiffness, 1e-6 * kStiffness);
  EXPECT_NEAR(motion.elements[0].damping.value, kDamping, 1e-5 * kDamping);
  EXPECT_TRUE(motion.missing.empty());
}

// One minute at 25 Hz and 1 kHz; both channels come together, up to a millisecond late.
TEST(Identify, RecoversTheClockOfADeviceThatHasOne) {
  Rig rig = mount();
  rig.excitation.frequency_hz = 25.0;
  rig.excitation.search_low_hz = 24.5;
  rig.excitation.search_high_hz = 25.5;
  rig.devices = {{"amplifier", 0.0, 0.0}};
  for (Channel& channel : rig.channels) channel.device = 0;
  CsvRecording recording;
  recording.channels = {"y0", "force"};
  std::mt19937_64 rng(4);
  std::uniform_real_distribution<double> late_s(0.0, 1e-3);
  for (int i = 0; i < 60'000; ++i) {
    const double t_s = i / 1000.0, angle = 2.0 * std::numbers::pi * 25.0 * t_s, stamp_s = t_s + late_s(rng);
    recording.samples.push_back({stamp_s, 0.5 * std::sin(angle), 0});
    recording.samples.push_back({stamp_s, 120.0 * std::sin(angle + 0.2), 1});
  }
  const auto amplitude = [&](Clock clock) {
    rig.devices[0].clock = clock;
    const std::vector<Dwell> found = identify(rig, recording);
    return found.size() == 1 ? std::abs(found[0].phasors[0].Y) : kNaN;
  };
  EXPECT_NEAR(amplitude(Clock::device), 0.5e-3, 0.2e-3 * 0.5e-3);
  EXPECT_LT(amplitude(Clock::host), (1.0 - 0.7e-3) * 0.5e-3) << "as stamped the jitter takes 0.1 % off";
}

TEST(Identify, ReportsTimesOnTheRecordingsOwnAxis) {
  const std::vector<Dwell> early = identify(mount(), recorded(0.0));
  const std::vector<Dwell> late = identify(mount(), recorded(500.0));
  ASSERT_EQ(late.size(), 1U);
  EXPECT_NEAR(late[0].start_s, early[0].start_s + 500.0, 1e-9);
  EXPECT_NEAR(late[0].settled_s, early[0].settled_s + 500.0, 1e-9);
  EXPECT_NEAR(late[0].verdict_s, early[0].verdict_s + 500.0, 1e-9);
  EXPECT_NEAR(late[0].end_s, early[0].end_s + 500.0, 1e-9);
  EXPECT_NEAR(late[0].t_ref_s, early[0].t_ref_s + 500.0, 1e-6);
  EXPECT_NEAR(late[0].memory_time_s, early[0].memory_time_s, 1e-9) << "a duration does not move";
}

TEST(Identify, ATableThatStandsStillYieldsNoDwell) { EXPECT_TRUE(identify(mount(), recorded(0.0, 1e-3)).empty()); }

TEST(Identify, IgnoresAColumnThatTheRigDoesNotKnow) {
  CsvRecording with = recorded(0.0);
  with.channels.emplace_back("temperature");
  std::vector<CsvRecording::Sample> samples;
  for (const CsvRecording::Sample& sample : with.samples) {
    samples.push_back(sample);
    samples.push_back({sample.t_s, 21.5, 2});
  }
  with.samples = samples;
  const ColumnMatch match = match_columns(mount(), with);
  EXPECT_EQ(match.unknown_columns, std::vector<std::string>{"temperature"});
  EXPECT_TRUE(match.missing_channels.empty());
  const std::vector<Dwell> dwells = identify(mount(), with);
  ASSERT_EQ(dwells.size(), 1U);
  EXPECT_EQ(dwells[0].elements.at(0).stiffness.value,
            identify(mount(), recorded(0.0)).at(0).elements.at(0).stiffness.value)
      << "to the last bit";
}

TEST(Identify, AMissingColumnMattersUnlessItsChannelIsAuxiliary) {
  Rig rig = mount();
  Channel temperature;
  temperature.name = "temperature";
  temperature.measures = Quantity::auxiliary;
  rig.channels.push_back(temperature);
  CsvRecording recording = recorded(0.0);
  recording.channels[1] = "torque";
  EXPECT_EQ(match_columns(rig, recording).missing_channels, std::vector<std::string>{"force"});
  EXPECT_EQ(match_columns(rig, recording).channel_of_column, (std::vector<int>{0, -1}));
}

TEST(Identify, TellsHowFarItIs) {
  std::vector<double> parts;
  const Rig rig = mount();
  ASSERT_TRUE(identify(rig, CsvSource(rig, recorded(0.0)), [&parts](double part) { parts.push_back(part); }));
  EXPECT_EQ(parts, std::vector<double>{1.0});
}

}  // namespace
}  // namespace dwell::ctl
