// A gateway that repeats its last answer now and then, at random: the repeats are left out and named, and the rest of
// the readings counts as if nothing had happened.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/core/disturbed_readings.hpp"

namespace dwell {
namespace {

struct RandomRepeats : DisturbedReadings {
  // Each reading is the one before with this probability: of one channel, or (channel below 0) of whole scans.
  Dwell repeated(double share, int channel, double noise, std::uint64_t seed, double until_s = 30) {
    rng.seed(seed);
    std::map<int, double> shown;
    std::int64_t scan_ns = INT64_MIN;
    bool again = false;
    return measured(
        [&](Record& record, double) {
          if (channel < 0 ? record.t_ns != scan_ns : record.channel == channel) again = uniform(rng) < share;
          scan_ns = record.t_ns;
          if (channel >= 0 && record.channel != channel) return;
          if (again && shown.contains(record.channel)) record.value = shown[record.channel];
          shown[record.channel] = record.value;
        },
        until_s, noise);
  }
  // wider: the largest U95 allowed, over that of the healthy rig.
  void expect_measured(const Dwell& dwell, const Dwell& healthy, int channel, const std::string& what,
                       double wider = 2) {
    expect_no_wrong_number(dwell, what, 4);
    ASSERT_EQ(dwell.elements.size(), 3u) << what << all(dwell);
    for (std::size_t e = 0; e < 3; ++e) {
      ASSERT_TRUE(dwell.elements[e].identifiable) << what << all(dwell);
      EXPECT_LT(dwell.elements[e].stiffness.U95, wider * healthy.elements[e].stiffness.U95) << what << ", c_" << e + 1;
      EXPECT_LT(dwell.elements[e].damping.U95, wider * healthy.elements[e].damping.U95) << what << ", r_" << e + 1;
    }
    for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c)
      if (channel < 0 || c == channel) {
        const std::string& name = rig.channels[static_cast<std::size_t>(c)].name;
        EXPECT_TRUE(says(dwell, name + ": ") && says(dwell, "repeat")) << what << all(dwell);
        EXPECT_EQ(conditions[static_cast<std::size_t>(c)], "gated") << what;
      }
    EXPECT_FALSE(says(dwell, "refresh")) << what << all(dwell);
  }
};

TEST_F(RandomRepeats, OfWholeScansCostNothingAndAreNamedAsRepeats) {
  const Dwell healthy = repeated(0.0, -1, 1e-3, 1);
  for (const double share : {0.005, 0.01, 0.02, 0.05})
    for (std::uint64_t seed = 1; seed <= 5; ++seed)
      expect_measured(repeated(share, -1, 1e-3, seed), healthy, -1,
                      std::to_string(share) + " of the scans, " + std::to_string(seed));
}

// Before it is known that readings are repeated, some ten repeats count where noise hides them. With little noise one
// in the first two periods, before the motion is known, weighs as much as all the noise.
TEST_F(RandomRepeats, OfWholeScansCostLittleWhateverTheNoise) {
  for (const double noise : {1e-4, 1e-2}) {
    const Dwell healthy = repeated(0.0, -1, noise, 1);
    for (const double share : {0.005, 0.01, 0.02, 0.05})
      for (std::uint64_t seed = 1; seed <= 3; ++seed)
        expect_measured(
            repeated(share, -1, noise, seed), healthy, -1,
            std::to_string(share) + " of the scans, noise " + std::to_string(noise) + ", " + std::to_string(seed), 10);
  }
}

TEST_F(RandomRepeats, OfOneChannelCostNothingAndAreNamedAsRepeats) {
  for (const double noise : {1e-3, 1e-2}) {
    const Dwell healthy = repeated(0.0, -1, noise, 1);
    for (const double share : {0.005, 0.01, 0.02, 0.05})
      for (const int channel : {0, 2, static_cast<int>(kCell)})
        expect_measured(
            repeated(share, channel, noise, 5), healthy, channel,
            std::to_string(share) + " of channel " + std::to_string(channel) + ", noise " + std::to_string(noise));
  }
}

TEST_F(RandomRepeats, AreNamedWithTheirPart) {
  const Dwell dwell = repeated(0.02, kCell, 1e-3, 1);
  const auto part = [&] {
    for (const Warning& warning : dwell.warnings)
      if (const auto at = warning.what.find("repeats of an older reading ("); at != std::string::npos)
        return std::stod(warning.what.substr(warning.what.find('(', at) + 1));
    return 0.0;
  };
  EXPECT_NEAR(part(), 2.0, 0.4) << all(dwell);
}

}  // namespace
}  // namespace dwell
