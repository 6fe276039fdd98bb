// The gate that tells readings of the motion from foreign ones: what it leaves out, and what it must not.
#include "core/intake/motion_gate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace dwell {
namespace {

constexpr double kGateStep = 1e-7;

// A sine of amplitude 1 with noise of 0.1 %, polled as fast as `interval_s` and the answers allow. The device samples
// somewhere between request and answer; an answer takes 0.2 … 0.6 ms, and one in fifty is held up by up to `held_up_s`.
class Polled {
 public:
  Polled(double f_hz, double interval_s, double held_up_s)
      : omega_(2 * std::numbers::pi * f_hz), interval_s_(interval_s), held_up_s_(held_up_s) {}

  MotionGate::Says next(MotionGate& gate, double times = 1.0) {
    double turnaround_s = 0.4e-3 * (0.5 + uniform_(rng_));
    if (uniform_(rng_) < 0.02) turnaround_s += held_up_s_ * uniform_(rng_);
    const double y = std::sin(omega_ * (request_s_ + turnaround_s * uniform_(rng_))) + 1e-3 * normal_(rng_);
    MotionGate::Reading reading{std::llround(1e9 * (request_s_ + 0.5 * turnaround_s)),
                                times * kGateStep * std::round(y / kGateStep)};
    reading.half_ns = static_cast<std::uint32_t>(0.5e9 * turnaround_s);
    request_s_ = std::max(request_s_ + turnaround_s, interval_s_ * (std::floor(request_s_ / interval_s_) + 1));
    return gate.judge(reading, omega_, kGateStep);
  }

 private:
  double omega_, interval_s_, held_up_s_, request_s_ = 0.0;
  std::mt19937 rng_{1};
  std::normal_distribution<> normal_;
  std::uniform_real_distribution<> uniform_{0.0, 1.0};
};

TEST(MotionGate, AnAnswerThatWasHeldUpMakesNoOtherReadingForeign) {
  for (const double f_hz : {2.0, 4.0, 8.0})
    for (const double interval_s : {2e-3, 5e-3, 10e-3})
      for (const double held_up_s : {3e-3, 10e-3, 30e-3, 100e-3}) {
        MotionGate gate;
        Polled polled(f_hz, interval_s, held_up_s);
        for (int i = 0; i < 20'000; ++i) polled.next(gate);
        EXPECT_LE(gate.foreign().all(), 2u) << f_hz << " Hz, every " << interval_s << " s, held up by " << held_up_s;
      }
}

TEST(MotionGate, ZerosAreFoundThoughAnswersAreHeldUp) {
  MotionGate gate;
  Polled polled(4.0, 5e-3, 30e-3);
  for (int i = 0; i < 9'700; ++i) polled.next(gate, i % 97 == 96 ? 0.0 : 1.0);
  EXPECT_GE(gate.foreign().all(), 95u) << "of 100; one in fifty came late, one in fifty where the motion is near zero";
  EXPECT_LE(gate.foreign().all(), 102u);
}

// Readings of a table at rest, answered in 0.2 … 0.6 ms, one in twenty in 8 ms; the drive is not known.
TEST(MotionGate, BeforeTheDriveIsKnownAnAnswerThatIsFarLateDoesNotCount) {
  MotionGate gate;
  std::mt19937 rng{2};
  std::uniform_int_distribution<std::uint32_t> quick_ns{100'000, 300'000};
  for (int i = 0; i < 2'000; ++i) {
    const bool late = i % 20 == 19;
    const MotionGate::Reading reading{5'000'000LL * i, 1e-3 * static_cast<double>(i % 7),
                                      late ? 4'000'000u : quick_ns(rng)};
    const auto expected = late ? MotionGate::Says::uncertain : MotionGate::Says::take;
    ASSERT_EQ(gate.judge(reading, 0.0, kGateStep), expected) << i;
  }
  EXPECT_EQ(gate.uncertain(), 100u);
}

}  // namespace
}  // namespace dwell
