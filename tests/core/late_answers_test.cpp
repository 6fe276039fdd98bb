// Which readings count in an estimate by the half widths of their instants.
#include "core/motion/late_answers.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/motion/motion_estimate.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr double kPace = 0.1;  // m/s
const std::vector<double> kNoiseOfIt{1e-5};

// A channel that moves evenly by kPace, read every 5 ms; usual half width 0.2 ms, which moves a reading by two
// standard deviations of kNoiseOfIt.
MotionData even_motion(int readings = 100) {
  MotionData data;
  for (int i = 0; i < readings; ++i)
    data.readings.push_back({5 * kMillisecond * i, 0, kPace * 5e-3 * i, static_cast<std::uint32_t>(kMillisecond / 5)});
  return data;
}

TEST(LateAnswers, TakesOutTheOneThatWasHeldUpAndNoOther) {
  MotionData data = even_motion();
  data.readings[40].half_ns = 80 * kMillisecond;
  EXPECT_EQ(leave_out_late(kNoiseOfIt, data), 1u);
  ASSERT_EQ(data.readings.size(), 99u);
  for (const MotionReading& reading : data.readings) EXPECT_NE(reading.t_ns, 200 * kMillisecond);
}

TEST(LateAnswers, KeepsAllWhereAllAreEquallyUncertain) {
  MotionData data = even_motion();
  for (MotionReading& reading : data.readings) reading.half_ns = 50 * kMillisecond;
  EXPECT_EQ(leave_out_late(kNoiseOfIt, data), 0u);
}

TEST(LateAnswers, KeepsAllWhereNoInstantIsUncertain) {
  MotionData data = even_motion();
  for (MotionReading& reading : data.readings) reading.half_ns = 0;
  EXPECT_EQ(leave_out_late(kNoiseOfIt, data), 0u);
}

// Of 40 mm at 0.4 Hz, 0.1 m/s at most. Twice the usual half width: 0.04 mm where it passes the middle, 0.01 mm of
// noise.
TEST(LateAnswers, KeepsAnAnswerThatWasHeldUpWhereTheMotionTurnsRound) {
  MotionData moving = even_motion(300), turning;
  for (MotionReading& reading : moving.readings) reading.value = 0.04 * std::sin(0.4 * kTwoPi * to_s(reading.t_ns));
  turning = moving;
  moving.readings[250].half_ns = turning.readings[125].half_ns = kMillisecond * 2 / 5;  // half a period, a quarter
  EXPECT_EQ(leave_out_late(kNoiseOfIt, moving), 1u);
  EXPECT_EQ(leave_out_late(kNoiseOfIt, turning), 0u);
}

TEST(LateAnswers, KeepsManyLateAnswersOfASlowMotion) {
  MotionData few = even_motion(), many = even_motion();
  for (MotionReading& reading : few.readings) reading.value = 0.0;
  for (MotionReading& reading : many.readings) reading.value = 0.0;
  few.readings[50].half_ns = 2 * kMillisecond;
  for (std::size_t i = 0; i < many.readings.size(); i += 5) many.readings[i].half_ns = 2 * kMillisecond;
  EXPECT_EQ(leave_out_late(kNoiseOfIt, few), 1u) << "ten medians: its true instant may lie in another motion";
  EXPECT_EQ(leave_out_late(kNoiseOfIt, many), 0u) << "one in five: they are this device's way";
}

// Forty of a hundred times the other channel's half width, so that no common median would keep them.
TEST(LateAnswers, JudgesEachChannelByItsOwnHalfWidths) {
  MotionData data = even_motion();
  for (int i = 0; i < 40; ++i)
    data.readings.push_back({5 * kMillisecond * i, 1, kPace * 5e-3 * i, static_cast<std::uint32_t>(20 * kMillisecond)});
  EXPECT_EQ(leave_out_late({1e-5, 1e-5}, data), 0u);
}

// An encoder: most neighbours are equal, so that its noise from reading to reading is none.
TEST(LateAnswers, TakesRoundingForNoise) {
  MotionData data = even_motion(300);
  for (MotionReading& reading : data.readings) reading.value = 1e-3 * std::floor(reading.value / 1e-3 + 0.3);
  for (std::size_t i = 0; i < data.readings.size(); i += 3) data.readings[i].half_ns = kMillisecond * 2 / 5;
  EXPECT_EQ(leave_out_late({0.0}, data), 0u);
}

TEST(LateAnswers, OfAnUnknownNoiseTakesOutWhatIsLateByFarAlone) {
  MotionData data = even_motion();
  data.readings[40].half_ns = kMillisecond * 2 / 5;
  data.readings[60].half_ns = 10 * kMillisecond;
  EXPECT_EQ(leave_out_late({kNaN}, data), 1u);
}

TEST(LateAnswers, HasNothingToDoWithoutReadings) {
  MotionData data;
  EXPECT_EQ(leave_out_late({1e-5, 1e-5}, data), 0u);
}

// A scan is answered 80 ms late and stamped in the middle, 40 ms off. Taken as certain, it leaves no estimate.
TEST(LateAnswers, OneLateScanSpoilsNoEstimate) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4.0);
  DrivenChain driven(chain, {4.0, 0.005, 0.0, 0.3}, DrivenChain::Start::rest);
  MotionData whole = readings_of(rig, driven, 0.0, 1.5, 200.0, {1e-5, 1e-5, 1e-5, 0.1}, 5), late, certain;
  for (MotionReading& reading : whole.readings) reading.half_ns = static_cast<std::uint32_t>(kMillisecond / 5);
  std::int64_t shown_ns = 0;
  for (MotionReading reading : whole.readings) {
    if (reading.t_ns >= 900 * kMillisecond && reading.t_ns < 980 * kMillisecond) {
      if (shown_ns == 0) shown_ns = reading.t_ns;
      if (reading.t_ns != shown_ns) continue;  // meanwhile nothing is asked
      reading.t_ns += 40 * kMillisecond;
      certain.readings.push_back(reading);
      reading.half_ns = 40 * kMillisecond;
    } else {
      certain.readings.push_back(reading);
    }
    late.readings.push_back(reading);
  }
  const MotionEstimate found = estimate_motion(rig, late);
  EXPECT_EQ(found.reason, "");
  EXPECT_TRUE(found.missing.empty());
  EXPECT_NE(estimate_motion(rig, certain, {.missing = false}).reason, "");
}

}  // namespace
}  // namespace dwell
