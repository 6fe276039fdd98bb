#include "core/drive/residual_blocks.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell {
namespace {

// A quarter of so many readings about centre_s, all with this residual, at the crest of the motion.
void add_quarter(ResidualBlocks& blocks, double centre_s, int readings, double residual) {
  for (int i = 0; i < readings; ++i)
    blocks.add(centre_s + 0.01 * (i - 0.5 * (readings - 1)), residual, {0.5, 2.0}, 0.1);
  EXPECT_TRUE(blocks.close());
}

TEST(ResidualBlocks, ABlockHoldsTheSumsOfItsReadings) {
  ResidualBlocks blocks;
  add_quarter(blocks, 3.0, 10, 0.2);
  const ResidualBlock& block = blocks.back(0);
  EXPECT_NEAR(block.t_s, 3.0, 1e-12);
  EXPECT_NEAR(block.rm, 10 * 0.2 * 2.0, 1e-12);
  EXPECT_NEAR(block.mm, 10 * 4.0, 1e-12);
  EXPECT_NEAR(block.rq, 10 * 0.2 * 0.5, 1e-12);
  EXPECT_NEAR(block.qq, 10 * 0.25, 1e-12);
  EXPECT_NEAR(block.extra_u2, 10 * 0.01, 1e-12);
  EXPECT_EQ(block.n, 10.0);
}

TEST(ResidualBlocks, AnEmptyQuarterIsNone) {
  ResidualBlocks blocks;
  EXPECT_FALSE(blocks.close());
  blocks.add(0.0, 1.0, {0.0, 1.0}, 0.0);
  blocks.drop_open();
  EXPECT_FALSE(blocks.close());
  EXPECT_EQ(blocks.seen(), 0);
}

TEST(ResidualBlocks, TheLatestAreKeptAndAllAreCounted) {
  ResidualBlocks blocks;
  for (int q = 0; q < ResidualBlocks::kLongest + 10; ++q) add_quarter(blocks, q, 1, 0.0);
  EXPECT_EQ(blocks.seen(), ResidualBlocks::kLongest + 10);
  EXPECT_EQ(blocks.kept(), ResidualBlocks::kLongest);
  EXPECT_EQ(blocks.back(0).t_s, ResidualBlocks::kLongest + 9.0);
  EXPECT_EQ(blocks.back(blocks.kept() - 1).t_s, 10.0);
  blocks.restart();
  EXPECT_EQ(blocks.kept(), 0);
}

TEST(ResidualBlocks, OneCrowdedQuarterHardlyChangesWhatIsUsual) {
  ResidualBlocks blocks;
  for (int q = 0; q < 40; ++q) add_quarter(blocks, q, 20, 0.0);
  EXPECT_NEAR(blocks.in_quarter(), 20.0, 0.1);
  add_quarter(blocks, 40, 1000, 0.0);
  EXPECT_LT(blocks.in_quarter(), 23.0);
}

// A drive that turns faster by δω since an instant leaves the residual δω τ q.
TEST(ResidualBlocks, TheSumsSinceAnInstantTellTheChangeOfFrequency) {
  ResidualBlocks blocks;
  constexpr double kFaster = 0.03, kBegin_s = 2.0;
  for (int q = 0; q < 20; ++q) {
    const double t_s = kBegin_s + 0.25 * q + 0.125;
    for (int i = 0; i < 2; ++i) blocks.add(t_s, kFaster * (t_s - kBegin_s) * 1.5, {1.5, 0.5}, 0.0);
    ASSERT_TRUE(blocks.close());
  }
  const double now_s = kBegin_s + 5.0;
  ResidualsSince sums;
  for (int k = 0; k < blocks.kept(); ++k) sums.take(blocks.back(k), now_s - blocks.back(k).t_s);
  EXPECT_EQ(sums.n, 40.0);
  EXPECT_NEAR(sums.score(5.0) / sums.weight(5.0), kFaster, 1e-12);
}

}  // namespace
}  // namespace dwell
