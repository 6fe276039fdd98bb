#include "config/observability.hpp"

#include <gtest/gtest.h>

namespace dwell::config {
namespace {

using Places = std::vector<int>;

TEST(Observability, OfAbsoluteTransducersNeedsOneAtEachPlace) {
  EXPECT_EQ(undetermined_places(2, {{0, {}}, {1, {}}, {2, {}}}), Places{});
  EXPECT_EQ(undetermined_places(2, {{0, {}}, {2, {}}}), Places{1});
  EXPECT_EQ(undetermined_places(1, {}), (Places{0, 1}));
}

TEST(Observability, FollowsTransducersAcrossElementsInEitherDirection) {
  EXPECT_EQ(undetermined_places(3, {{1, 0}, {2, 1}, {3, 2}, {0, {}}}), Places{});
  EXPECT_EQ(undetermined_places(3, {{1, 0}, {2, 1}, {3, 2}, {3, {}}}), Places{});
  EXPECT_EQ(undetermined_places(3, {{0, {}}, {3, 0}, {2, 3}, {2, 1}}), Places{});
}

TEST(Observability, IsNotGivenByDifferencesAlone) {
  EXPECT_EQ(undetermined_places(3, {{1, 0}, {2, 1}, {3, 2}}), (Places{0, 1, 2, 3}));
  EXPECT_EQ(undetermined_places(3, {{0, {}}, {1, {}}, {3, 2}}), (Places{2, 3}));
}

TEST(Observability, IgnoresTransducersOutsideTheChain) {
  EXPECT_EQ(undetermined_places(1, {{0, {}}, {7, {}}, {1, 9}, {-1, {}}}), Places{1});
}

TEST(Observability, OfNoMassesNeedsTheTableAlone) { EXPECT_EQ(undetermined_places(0, {{0, {}}}), Places{}); }

}  // namespace
}  // namespace dwell::config
