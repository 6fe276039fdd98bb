#include "daemon/estimate/kept_dwells.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

// A chain of 30 elements, as large as its covariance and its budgets make it.
Dwell large_dwell(int index) {
  Dwell dwell;
  dwell.index = index;
  dwell.covariance.assign(3600, 1.0);
  dwell.elements.resize(30);
  for (ElementEstimate& element : dwell.elements)
    element.budget.assign(90, BudgetShare{"turnaround of the transaction of y1", 0.1, 0.1, SourceKind::other, {}});
  return dwell;
}

TEST(KeptDwells, TakeNoMoreMemoryHoweverManyThereHaveBeen) {
  constexpr std::size_t kMost_bytes = 8'000'000;
  KeptDwells kept(1000, kMost_bytes);
  for (int i = 1; i <= 300; ++i) kept.push(large_dwell(i));
  EXPECT_LE(kept.bytes(), kMost_bytes);
  EXPECT_GT(kept.bytes(), kMost_bytes / 2) << "but are not thrown away without need";
  EXPECT_EQ(kept.list()->back()->index, 300);
  EXPECT_EQ(kept.list()->size() + kept.forgotten(), 300u);
  std::size_t bytes = 0;
  for (const auto& dwell : *kept.list()) bytes += bytes_of(*dwell);
  EXPECT_EQ(bytes, kept.bytes());
}

TEST(KeptDwells, AreTheNewestOfTheirNumber) {
  KeptDwells kept(3, 1'000'000'000);
  for (int i = 1; i <= 5; ++i) kept.push(large_dwell(i));
  ASSERT_EQ(kept.list()->size(), 3u);
  EXPECT_EQ(kept.list()->front()->index, 3);
  EXPECT_EQ(kept.forgotten(), 2u);
}

TEST(KeptDwells, HoldTheNewestHoweverLarge) {
  KeptDwells kept(1000, 1);
  kept.push(large_dwell(1));
  kept.push(large_dwell(2));
  ASSERT_EQ(kept.list()->size(), 1u);
  EXPECT_EQ(kept.list()->front()->index, 2);
}

TEST(KeptDwells, AListHandedOutStaysAsItWas) {
  KeptDwells kept(1, 1'000'000'000);
  kept.push(large_dwell(1));
  const auto before = kept.list();
  kept.push(large_dwell(2));
  ASSERT_EQ(before->size(), 1u);
  EXPECT_EQ(before->front()->index, 1);
}

}  // namespace
}  // namespace dwell
