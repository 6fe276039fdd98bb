#include "core/base/median.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

TEST(Median, IsTheMiddleOneInAnyOrder) {
  EXPECT_EQ(median<int>({3, 1, 2}), 2);
  EXPECT_EQ(median<double>({7.0}), 7.0);
}

TEST(Median, OfAnEvenNumberIsTheUpperOne) { EXPECT_EQ(median<int>({4, 1, 3, 2}), 3); }

}  // namespace
}  // namespace dwell
