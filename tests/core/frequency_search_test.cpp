// The search for a drive of which only the search range is known.
#include "core/drive/frequency_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

constexpr double kSearchLow_hz = 3.0, kSearchHigh_hz = 8.0, kSearchRate_hz = 200.0;

Rig searched_rig(double low_hz, double high_hz, Reference reference = Reference::tracked) {
  Rig rig;
  rig.excitation.frequency_hz = 4.0;
  rig.excitation.search_low_hz = low_hz;
  rig.excitation.search_high_hz = high_hz;
  rig.excitation.reference = reference;
  return rig;
}

// A sine of unit amplitude about a mean, with its second harmonic and noise, in channel 1; another sine in channel 0.
struct SearchedTable {
  double hz, phase_rad = 0.0, second = 0.0, noise = 1e-3;
  std::uint64_t seed = 1;

  // ω found in the first `seconds`, Hz; 0: none.
  [[nodiscard]] double found_hz(double seconds) const {
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    SampleHistory history(4096);
    for (int i = 0; i < static_cast<int>(seconds * kSearchRate_hz); ++i) {
      const double t_s = i / kSearchRate_hz, angle = kTwoPi * hz * t_s + phase_rad;
      history.push(std::llround(1e9 * t_s), 0, std::sin(kTwoPi * 5.0 * t_s));
      history.push(std::llround(1e9 * t_s), 1,
                   7.0 + std::sin(angle) + second * std::sin(2 * angle) + noise * normal(rng));
    }
    FrequencySearch search(searched_rig(kSearchLow_hz, kSearchHigh_hz));
    const auto found = search.find(history, 1, 0, std::llround(1e9 * seconds));
    return found ? *found / kTwoPi : 0.0;
  }
};

TEST(FrequencySearch, FindsASineAnywhereInTheRangeFromOnePeriodOfTheLowest) {
  for (double hz = 3.05; hz < 8.0; hz += 0.15)
    for (double phase_rad = 0.0; phase_rad < kTwoPi; phase_rad += 0.7)
      EXPECT_NEAR((SearchedTable{.hz = hz, .phase_rad = phase_rad}.found_hz(1 / kSearchLow_hz)), hz, 0.01) << phase_rad;
}

TEST(FrequencySearch, TakesTheFundamentalOfADistortedSineAndNeverItsHalf) {
  for (double hz = 3.1; hz < 8.0; hz += 0.2)
    for (double phase_rad = 0.0; phase_rad < kTwoPi; phase_rad += 0.7)
      EXPECT_NEAR((SearchedTable{.hz = hz, .phase_rad = phase_rad, .second = 0.1}.found_hz(1 / kSearchLow_hz)), hz, 0.4)
          << phase_rad;
}

TEST(FrequencySearch, FindsNothingInNoiseNorInLessThanHalfAPeriodOfTheLowest) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed)
    found += SearchedTable{.hz = 5.0, .noise = 1e3, .seed = seed}.found_hz(1 / kSearchLow_hz) > 0;
  EXPECT_EQ(found, 0);
  EXPECT_EQ(SearchedTable{.hz = 5.0}.found_hz(0.45 / kSearchLow_hz), 0.0);
}

TEST(FrequencySearch, IsNotWantedInARangeOfOneCellNorWhereTheFrequencyIsStated) {
  EXPECT_TRUE(FrequencySearch(searched_rig(3, 8)).wanted());
  EXPECT_FALSE(FrequencySearch(searched_rig(3.92, 4.08)).wanted());
  EXPECT_FALSE(FrequencySearch(searched_rig(3, 8, Reference::fixed)).wanted());
}

}  // namespace
}  // namespace dwell
