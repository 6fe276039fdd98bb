#include "daemon/record/ahead.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace dwell::record {
namespace {

TEST(Ahead, HandsOutEverythingInOrderAndThenNothing) {
  int made = 0;
  Ahead<int> ahead([&]() -> std::optional<int> { return made < 1000 ? std::optional(made++) : std::nullopt; }, 2);
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(ahead.next(), i);
  EXPECT_FALSE(ahead.next());
  EXPECT_FALSE(ahead.next());
}

TEST(Ahead, MakesNoMoreAheadThanItMay) {
  std::atomic<int> made{0};
  Ahead<int> ahead([&]() -> std::optional<int> { return ++made; }, 3);
  for (int i = 1; i <= 100; ++i) {
    ASSERT_EQ(ahead.next(), i);
    ASSERT_LE(made, i + 3) << "those that wait or are being made, beside those handed out";
  }
}

TEST(Ahead, WhoStopsTakingWaitsForNothing) {
  int made = 0;
  Ahead<int> ahead([&]() -> std::optional<int> { return ++made; }, 1);
  EXPECT_EQ(ahead.next(), 1);
}

TEST(Ahead, WhatTheMakerThrowsComesAfterWhatItMade) {
  int made = 0;
  Ahead<int> ahead(
      [&]() -> std::optional<int> {
        if (made == 2) throw std::runtime_error("no more");
        return ++made;
      },
      5);
  EXPECT_EQ(ahead.next(), 1);
  EXPECT_EQ(ahead.next(), 2);
  EXPECT_THROW((void)ahead.next(), std::runtime_error);
  EXPECT_FALSE(ahead.next());
}

}  // namespace
}  // namespace dwell::record
