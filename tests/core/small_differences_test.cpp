#include "core/intake/small_differences.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>

namespace dwell {
namespace {

SmallDifferences differences_of(std::initializer_list<double> sizes) {
  SmallDifferences differences;
  for (const double size : sizes) differences.add(size);
  return differences;
}

TEST(SmallDifferences, TheStepIsTheThirdSmallestWhateverTheOrder) {
  EXPECT_EQ(differences_of({5.0, 1.0, 4.0, 2.0, 3.0}).step(), 3.0);
  EXPECT_EQ(differences_of({1.0, 2.0, 3.0, 4.0, 5.0}).step(), 3.0);
  EXPECT_EQ(differences_of({5.0, 1.0, 4.0, 2.0, 3.0}).least(), 1.0);
}

TEST(SmallDifferences, TwoTellNoStep) {
  EXPECT_TRUE(std::isinf(differences_of({1.0, 2.0}).step()));
  EXPECT_EQ(differences_of({2.0, 1.0}).least(), 1.0);
}

TEST(SmallDifferences, ThoseWithinOneAndAHalfStepsAreOne) {
  EXPECT_EQ(differences_of({1.0, 1.0, 1.0, 1.4, 1.6, 1.0}).one_step(), 5);
}

TEST(SmallDifferences, ASmallerStepMakesTheOthersMore) {
  // Four of 3, then three of 1: the first two of these do not make a step yet.
  EXPECT_EQ(differences_of({3.0, 3.0, 3.0, 3.0, 1.0, 1.0, 1.0}).one_step(), 3);
}

TEST(SmallDifferences, RestartedNothingIsKnown) {
  SmallDifferences differences = differences_of({1.0, 1.0, 1.0});
  differences.restart();
  EXPECT_TRUE(std::isinf(differences.step()));
  EXPECT_EQ(differences.one_step(), 0);
}

}  // namespace
}  // namespace dwell
