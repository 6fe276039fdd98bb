#include "core/motion/level_crossings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/table_activity.hpp"
#include "tests/core/motion_case.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kMs = 1'000'000;

Rig one_channel() {
  Rig rig;
  rig.channels.emplace_back().name = "y0";
  return rig;
}

MotionData readings(const std::vector<double>& values) {
  MotionData data;
  for (const double value : values)
    data.readings.push_back({static_cast<std::int64_t>(data.readings.size()) * 2 * kMs, 0, value});
  return data;
}

// Of a slow sine in steps of 1; then a still table, then steps of several levels.
std::vector<double> staircase() {
  std::vector<double> values;
  for (int i = 0; i < 200; ++i) values.push_back(std::round(5.0 * std::sin(kTwoPi * i / 200.0)));
  return values;
}

void round_to(double step, MotionData& data) {
  for (MotionReading& reading : data.readings) reading.value = step * std::round(reading.value / step);
}

TEST(LevelCrossings, EqualReadingsAreLeftOutAndAStepIsTheEdgeBetweenItsLevels) {
  MotionData data = readings(staircase());
  EXPECT_EQ(take_level_crossings(one_channel(), {0.0}, data), std::vector<int>{0});
  ASSERT_FALSE(data.readings.empty());
  for (const MotionReading& reading : data.readings) {
    EXPECT_EQ(std::abs(reading.value - std::floor(reading.value)), 0.5);
    // The sine passes the edge between the two readings, 2 ms apart.
    const double i = static_cast<double>(reading.t_ns) / static_cast<double>(2 * kMs);
    EXPECT_LT(std::abs(5.0 * std::sin(kTwoPi * i / 200.0) - reading.value), 0.5 * 5.0 * kTwoPi / 200.0 + 1e-9);
  }
}

TEST(LevelCrossings, AReadingSeveralLevelsOnStaysAsItIs) {
  std::vector<double> values = staircase();
  for (const double far : {3.0, 9.0, 4.0}) values.push_back(far);
  MotionData data = readings(values);
  take_level_crossings(one_channel(), {0.0}, data);
  ASSERT_GE(data.readings.size(), 3u);
  EXPECT_EQ(data.readings.back().value, 4.0);
  EXPECT_EQ(data.readings[data.readings.size() - 2].value, 9.0);
}

TEST(LevelCrossings, NoiseThatSmoothsTheRoundingLeavesAllReadings) {
  MotionData data = readings(staircase());
  const std::size_t count = data.readings.size();
  EXPECT_TRUE(take_level_crossings(one_channel(), {0.5}, data).empty());
  EXPECT_EQ(data.readings.size(), count);
}

TEST(LevelCrossings, ReadingsWithoutAStepStay) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  MotionData data;
  for (int i = 0; i < 300; ++i) data.readings.push_back({i * 2 * kMs, 0, normal(rng)});
  EXPECT_TRUE(take_level_crossings(one_channel(), {0.0}, data).empty());
  EXPECT_EQ(data.readings.size(), 300u);
}

// Encoders of 0.02 mm, a table that moves by 8 mm, is still for a second, and moves again: taken as they are the
// readings contradict the chain that made them.
TEST(LevelCrossings, EncodersThatStandStillDoNotContradictTheChain) {
  double squares = 0.0, count = 0.0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(draws(8, 2)); ++seed) {
    std::mt19937_64 rng(seed);
    const Chain chain = random_chain(rng, 1 + static_cast<int>(seed % 2), Boundary::free, 4.0);
    const Rig rig = rig_of(chain, 4.0);
    DrivenChain driven(chain, {4.0, 0.008, 0.0, 0.3}, DrivenChain::Start::rest);
    MotionData data = readings_of(rig, driven, 0.0, 2.0, 250.0, std::vector<double>(rig.channels.size(), 0.0), seed);
    driven.set_drive(2.0, {4.0, 0.0, 0.0, 0.3});
    const MotionData still =
        readings_of(rig, driven, 2.0, 5.0, 250.0, std::vector<double>(rig.channels.size(), 0.0), seed);
    data.readings.insert(data.readings.end(), still.readings.begin(), still.readings.end());
    round_to(2e-5, data);
    const MotionEstimate found = estimate_motion(rig, data);
    ASSERT_EQ(found.reason, "") << seed;
    for (std::size_t e = 0; e < found.elements.size(); ++e)
      for (const auto& [seen, truth] : {std::pair{found.elements[e].stiffness, chain.stiffness[e]},
                                        std::pair{found.elements[e].damping, chain.damping[e]}}) {
        EXPECT_LT(std::abs(seen.value - truth), 4 * seen.u) << seed;
        squares += std::pow((seen.value - truth) / seen.u, 2);
        ++count;
      }
  }
  EXPECT_LT(squares / count, 2.0);
}

}  // namespace
}  // namespace dwell
