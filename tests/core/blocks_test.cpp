#include "core/fit/blocks.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell {
namespace {

constexpr std::int64_t kQuarter_ns = 250'000'000;
constexpr double kOneTurn = 2 * M_PI;  // rad/s: a period of a second

// So many quarter blocks of one channel, ten samples of 1 in each.
void fill_blocks(Blocks& blocks, int quarters) {
  for (int q = 0; q < quarters; ++q) {
    const std::int64_t begin_ns = blocks.serials() * kQuarter_ns;
    blocks.open(begin_ns, begin_ns + kQuarter_ns, kOneTurn);
    for (int i = 0; i < 10; ++i) blocks.add(0, begin_ns + i * (kQuarter_ns / 10), 1.0);
    blocks.close();
  }
}
double samples_of(const Blocks& blocks) {
  double sum = 0.0;
  for (int i = 0; i < blocks.count(); ++i) sum += blocks.samples(i, 0);
  return sum;
}

TEST(Blocks, TheNewestStayFineAndNoneIsDroppedHoweverManyThereAre) {
  Blocks blocks(1, 1);
  fill_blocks(blocks, 20'000);
  EXPECT_LE(blocks.count(), Blocks::kCapacity);
  EXPECT_EQ(samples_of(blocks), 200'000.0);
  for (int i = blocks.count() - Blocks::kFine; i < blocks.count(); ++i) EXPECT_EQ(blocks.block(i).quarters, 1);
  EXPECT_EQ(blocks.block(0).begin_ns, 0);
  for (int i = 1; i < blocks.count(); ++i) {
    EXPECT_EQ(blocks.block(i).begin_ns, blocks.block(i - 1).end_ns);
    EXPECT_LE(blocks.block(i).quarters, blocks.block(i - 1).quarters) << "the older, the longer";
    EXPECT_EQ(blocks.block(i).first_serial, blocks.block(i - 1).first_serial + blocks.block(i - 1).quarters);
  }
}

TEST(Blocks, ASerialNumberIsFoundAgainOrTheNextBlockBegin) {
  Blocks blocks(1, 1);
  fill_blocks(blocks, 1000);
  for (std::int64_t serial = 0; serial < 1000; ++serial) {
    const int i = blocks.index_of(serial);
    if (i < blocks.count()) {
      EXPECT_GE(blocks.block(i).first_serial, serial);
    }
    if (i > 0) {
      EXPECT_LT(blocks.block(i - 1).first_serial, serial);
    }
  }
  EXPECT_EQ(blocks.index_of(1000), blocks.count());
}

TEST(Blocks, OnlyThatEndBeforeAreForgotten) {
  Blocks blocks(1, 1);
  fill_blocks(blocks, 20);
  EXPECT_FALSE(blocks.forget_before(kQuarter_ns - 1));
  EXPECT_TRUE(blocks.forget_before(5 * kQuarter_ns + 1));
  EXPECT_EQ(blocks.block(0).begin_ns, 5 * kQuarter_ns);
  EXPECT_EQ(blocks.serials(), 20);
}

TEST(Blocks, ARestartKeepsSerialNumbersAndReferencesAndAClearTheReferences) {
  Blocks blocks(1, 1);
  blocks.set_reference(0, 3.0);
  fill_blocks(blocks, 20);
  blocks.restart();
  EXPECT_EQ(blocks.count(), 0);
  EXPECT_EQ(blocks.serials(), 20);
  blocks.clear();
  EXPECT_EQ(blocks.serials(), 0);
  EXPECT_EQ(blocks.reference(0), 3.0);
}

TEST(Blocks, TheOpenOneIsAddedOnlyByName) {
  Blocks blocks(1, 1);
  Totals totals(1, 1);
  fill_blocks(blocks, 4);
  blocks.open(kQuarter_ns * 4, kQuarter_ns * 5, kOneTurn);
  blocks.add(0, kQuarter_ns * 4, 1.0);
  blocks.sum(0, blocks.count(), kOneTurn, 0, totals);
  EXPECT_EQ(totals.channel(0).instants[0], 40.0);
  blocks.add_open(totals);
  EXPECT_EQ(totals.channel(0).instants[0], 41.0);
}

TEST(Blocks, OneChannelAloneSumsAsAmongAll) {
  Blocks blocks(2, 1);
  for (int q = 0; q < 300; ++q) {
    const std::int64_t begin_ns = q * kQuarter_ns;
    blocks.open(begin_ns, begin_ns + kQuarter_ns, kOneTurn);
    for (int i = 0; i < 10; ++i)
      for (int c = 0; c < 2; ++c) blocks.add(c, begin_ns + i * (kQuarter_ns / 10), std::sin(0.1 * i + c + q));
    blocks.close();
  }
  Totals all(2, 1), one(2, 1);
  blocks.sum(0, blocks.count(), 1.0001 * kOneTurn, 7, all);
  one.restart(0.0, 0);
  blocks.sum_channel(1, 0, blocks.count(), 1.0001 * kOneTurn, 7, one);
  for (std::size_t i = 0; i < moments::size(2); ++i)
    EXPECT_EQ(all.channel(1).readings[i], one.channel(1).readings[i]) << i;
  for (std::size_t i = 0; i < moments::size(3); ++i)
    EXPECT_EQ(all.channel(1).instants[i], one.channel(1).instants[i]) << i;
}

}  // namespace
}  // namespace dwell
