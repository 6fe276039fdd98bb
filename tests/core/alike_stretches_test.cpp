#include "core/motion/alike_stretches.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace dwell {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The definition, step by step: of all neighbours the two most alike, again and again.
std::vector<AlikeStretches::Stretch> by_definition(const std::vector<double>& logarithms, double apart,
                                                   std::size_t most) {
  std::vector<AlikeStretches::Stretch> pieces;
  for (std::size_t i = 0; i < logarithms.size(); ++i) pieces.push_back({i, logarithms[i], 1});
  while (pieces.size() > 1) {
    std::size_t best = 1;
    double least = kInfinity;
    for (std::size_t i = 1; i < pieces.size(); ++i)
      if (const double off = std::abs(pieces[i].logarithm - pieces[i - 1].logarithm); off < least) {
        least = off;
        best = i;
      }
    if (least > apart && pieces.size() <= most) break;
    AlikeStretches::Stretch &into = pieces[best - 1], &from = pieces[best];
    const auto a = static_cast<double>(into.blocks), b = static_cast<double>(from.blocks);
    into.logarithm = (into.logarithm * a + from.logarithm * b) / (a + b);
    into.blocks += from.blocks;
    pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return pieces;
}

// Random blocks; some are equal, some infinite.
std::vector<double> blocks(std::size_t n, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> part(-3.0, 3.0);
  std::vector<double> logarithms;
  for (std::size_t i = 0; i < n; ++i) {
    const double value = part(rng);
    logarithms.push_back(rng() % 5 == 0 ? std::round(value) : rng() % 97 == 0 ? kInfinity : value);
  }
  return logarithms;
}

TEST(AlikeStretches, AreThoseOfTheDefinitionToTheBit) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const std::vector<double> logarithms = blocks(seed % 60, seed);
    const auto expected = by_definition(logarithms, 1.16, 5);
    const auto seen = join_alike(logarithms, 1.16, 5).stretches;
    ASSERT_EQ(seen.size(), expected.size()) << seed;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_EQ(seen[i].first, expected[i].first) << seed;
      EXPECT_EQ(seen[i].blocks, expected[i].blocks) << seed;
      EXPECT_TRUE(seen[i].logarithm == expected[i].logarithm ||
                  (std::isnan(seen[i].logarithm) && std::isnan(expected[i].logarithm)))
          << seed;
    }
  }
}

TEST(AlikeStretches, TheWorkGrowsWithTheBlocksNotWithTheirSquare) {
  for (const std::size_t n : {1'000u, 10'000u, 100'000u}) {
    std::vector<double> ramp;  // a hostile file: each join changes which neighbours are the most alike
    for (std::size_t i = 0; i < n; ++i) ramp.push_back(1e-9 * static_cast<double>(i * i % 7919));
    EXPECT_LE(join_alike(ramp, 1.16, 5).compared, 3 * n);
    EXPECT_LE(join_alike(blocks(n, n), 1.16, 5).compared, 3 * n);
  }
}

}  // namespace
}  // namespace dwell
