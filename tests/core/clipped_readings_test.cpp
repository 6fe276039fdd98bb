// A channel that is clipped, always or for a while, hard or softly, is named, and gives no wrong number without a word.
#include "tests/core/disturbed_readings.hpp"

namespace dwell {
namespace {

using ClippedReadings = DisturbedReadings;

// As where the operator follows the advice to choose a larger range.
TEST_F(ClippedReadings, WhatWasMeasuredWhileAChannelWasClippedStaysWithheldThoughTheClippingEnds) {
  for (const double end : {0.2, 0.5, 0.8, 0.95})
    for (const double until_s : {31.0, 35.0}) {
      const std::string what = "cut off at " + std::to_string(end) + ", then 5 s and " + std::to_string(until_s - 30);
      const double limit = end * std::abs(steady_response(chain, 2 * M_PI * 4, 0.002).Y[1]);
      const Dwell dwell = measured(
          [&](Record& record, double t) {
            if (record.channel == 1 && t < 30) record.value = std::clamp(record.value, -limit, limit);
          },
          until_s);
      expect_no_wrong_number(dwell, what);
      EXPECT_FALSE(dwell.elements[0].identifiable) << what << all(dwell);
      EXPECT_TRUE(says(dwell, "y1: clipped")) << what << all(dwell);
    }
}

// As where the amplitude is not what changes, but the amplifier's range.
TEST_F(ClippedReadings, AChannelThatIsClippedFromSomeInstantOnIsNamedAndWithheld) {
  for (const double end : {0.2, 0.5, 0.8, 0.95}) {
    const std::string what = "cut off at " + std::to_string(end);
    const double limit = end * std::abs(steady_response(chain, 2 * M_PI * 4, 0.002).Y[1]);
    const Dwell dwell = measured(
        [&](Record& record, double t) {
          if (record.channel == 1 && t > 20) record.value = std::clamp(record.value, -limit, limit);
        },
        36);  // the stretch that holds the change may end first; then 16 periods, 4 s, are enough
    expect_no_wrong_number(dwell, what);
    EXPECT_FALSE(dwell.elements[0].identifiable) << what << all(dwell);
    EXPECT_TRUE(says(dwell, "y1: clipped")) << what << all(dwell);
    EXPECT_EQ(conditions[1], "clipped") << what;
  }
}

TEST_F(ClippedReadings, AClippedLoadCellIsNamedAndWithheldAndTheOthersAreMeasured) {
  for (const double level : {0.5, 0.8, 0.9, 0.97})
    for (const bool both : {true, false})
      for (const double noise : {1e-4, 1e-3, 1e-2}) {
        const double limit = level * force();
        const Dwell dwell = measured(
            [&](Record& record, double) {
              if (record.channel == kCell) record.value = std::clamp(record.value, both ? -limit : -1e9, limit);
            },
            30, noise);
        const std::string what =
            std::to_string(level) + (both ? " both, noise " : " above, noise ") + std::to_string(noise);
        expect_no_wrong_number(dwell, what);
        EXPECT_TRUE(says(dwell, "reaction: clipped")) << what << all(dwell);
        EXPECT_EQ(conditions[kCell], "clipped") << what;
        ASSERT_EQ(dwell.phasors.size(), 4u) << what;
        for (std::size_t c = 0; c < kCell; ++c) EXPECT_TRUE(dwell.phasors[c].valid) << what << dwell.phasors[c].reason;
        // Clipped by 3 % the amplitude is off by 0.3 %: within what 1 % of noise leaves.
        EXPECT_TRUE(!dwell.phasors[kCell].valid || level > 0.9) << what;
        if (!dwell.phasors[kCell].valid) {
          EXPECT_NE(dwell.phasors[kCell].reason.find("clipped"), std::string::npos) << dwell.phasors[kCell].reason;
          for (const ElementEstimate& element : dwell.elements) {
            EXPECT_FALSE(element.identifiable) << what;
            EXPECT_NE(element.reason.find("reaction"), std::string::npos) << what << element.reason;
          }
        }
        EXPECT_TRUE(dwell.doubts.empty()) << what << ", the specimen is blamed: " << dwell.doubts.front().what;
        for (const char* blame : {"not linear", "mode at", "friction", "settle"})
          EXPECT_FALSE(says(dwell, blame)) << what << all(dwell);
      }
}

// Clipping at 89 % cuts off less than five steps of 6 % or 3 % of the amplitude: so little is not found.
TEST_F(ClippedReadings, AClippedChannelWhoseCoarseRoundingHidesTheClippingIsNamedForItsRounding) {
  const double amplitude = std::abs(steady_response(chain, 2 * M_PI * 4, 0.002).Y[1]);
  for (const double step : {0.064, 0.03}) {
    const Dwell dwell = measured([&](Record& record, double) {
      if (record.channel != 1) return;
      record.value = std::clamp(record.value, -0.89 * amplitude, 0.89 * amplitude);
      record.value = step * amplitude * std::round(record.value / (step * amplitude));
    });
    EXPECT_TRUE(says(dwell, "y1: its readings are rounded to steps of ")) << step << all(dwell);
  }
  const Dwell fine = measured([&](Record& record, double) {
    if (record.channel == 1) record.value = 0.002 * amplitude * std::round(record.value / (0.002 * amplitude));
  });
  EXPECT_FALSE(says(fine, "rounded to steps")) << all(fine);
}

// A transducer that saturates smoothly has no pile-up; its third harmonic shows it.
TEST_F(ClippedReadings, ATransducerThatSaturatesSoftlyIsNamed) {
  const std::vector<double> amplitude = sigma(1.0);
  for (const std::uint16_t c : {std::uint16_t{1}, std::uint16_t{2}, kCell})
    for (const double soft : {0.2, 0.5}) {
      const double reach = amplitude[c] / soft;
      const Dwell dwell = measured([&](Record& record, double) {
        if (record.channel == c) record.value = reach * std::tanh(record.value / reach);
      });
      EXPECT_FALSE(trustworthy(dwell)) << c << " " << soft << all(dwell);
      const std::string named = rig.channels[c].name + " distorts";
      EXPECT_TRUE(std::any_of(dwell.doubts.begin(), dwell.doubts.end(),
                              [&](const Doubt& doubt) { return doubt.what.find(named) != std::string::npos; }))
          << c << " " << soft << all(dwell);
    }
}

}  // namespace
}  // namespace dwell
