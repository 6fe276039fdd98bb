#include "core/stream/grid_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace dwell {
namespace {

constexpr double kGridPeriod_ns = 1e6;

// So many more arrivals of a steady device, each late by up to `jitter` periods. Arrivals until a grid was found; -1:
// none was.
struct SteadyArrivals {
  int feed(GridSearch& search, int arrivals) {
    for (int i = 1; i <= arrivals; ++i, ++k) {
      const double late = std::uniform_real_distribution<double>(0.0, jitter)(rng);
      if (search.add(9'000'000'000 + std::llround(kGridPeriod_ns * (k + late)))) return i;
    }
    return -1;
  }
  double jitter = 0.0, k = 0.0;
  std::mt19937_64 rng{1};
};

TEST(GridSearch, AShortStretchIsEnoughWhereJitterIsSmall) {
  GridSearch search(0.0);
  SteadyArrivals device{0.02};
  EXPECT_EQ(device.feed(search, 1000), 64);
  EXPECT_EQ(search.count(), 64u);
  EXPECT_GE(search.begin_ns(), 9'000'000'000);
  EXPECT_LE(search.begin_ns(), 9'000'020'000);
}

TEST(GridSearch, WhereJitterIsLargeALongerStretchIsTaken) {
  GridSearch search(kGridPeriod_ns);
  SteadyArrivals device{0.9};
  EXPECT_EQ(device.feed(search, 1000), 256);
}

TEST(GridSearch, ASourceWithoutARateIsTriedEverMoreSeldom) {
  GridSearch search(0.0);
  std::mt19937_64 rng(2);
  std::exponential_distribution<double> wait(1e-6);
  double t = 0.0;
  std::vector<int> failed;
  std::size_t before = 0;
  for (int i = 0; i < 10'000; ++i) {
    ASSERT_FALSE(search.add(std::llround(t += wait(rng))));
    if (before > 0 && search.count() == 0) failed.push_back(i);
    before = search.count();
  }
  ASSERT_GE(failed.size(), 5u);
  // A stretch of 256, now and then a few more, after a pause that doubles.
  for (std::size_t i = 1; i < failed.size(); ++i)
    EXPECT_NEAR(failed[i] - failed[i - 1], 256 + (128 << i), 8) << "attempt " << i;
}

TEST(GridSearch, RestartedItDoesNotPause) {
  GridSearch search(0.0);
  std::mt19937_64 rng(3);
  std::exponential_distribution<double> wait(1e-6);
  double t = 0.0;
  for (int i = 0; i < 300; ++i) EXPECT_FALSE(search.add(std::llround(t += wait(rng))));
  search.restart();
  SteadyArrivals device{0.02};
  EXPECT_EQ(device.feed(search, 1000), 64);
}

TEST(GridSearch, AStatedPeriodThatIsNotTheStreamsIsForgotten) {
  GridSearch search(kGridPeriod_ns / 3);
  SteadyArrivals device{0.02};
  EXPECT_EQ(device.feed(search, 1000), 64);
  EXPECT_EQ(search.nominal_ns(), 0.0);
}

TEST(GridSearch, AStatedPeriodThatHelpsIsKept) {
  GridSearch search(1.0001 * kGridPeriod_ns);
  SteadyArrivals device{0.02};
  EXPECT_EQ(device.feed(search, 1000), 64);
  EXPECT_EQ(search.nominal_ns(), 1.0001 * kGridPeriod_ns);
}

TEST(GridSearch, DoesNotBeginAmidABunch) {
  GridSearch search(0.0);
  SteadyArrivals device{0.02};
  EXPECT_EQ(device.feed(search, 54), -1);
  // The next ten were held up and come together.
  for (int i = 0; i < 10; ++i, ++device.k)
    EXPECT_FALSE(search.add(9'000'000'000 + std::llround(kGridPeriod_ns * 64) + 1000 * i));
  EXPECT_GT(device.feed(search, 1000), 100) << "at the end of the longer stretch";
}

}  // namespace
}  // namespace dwell
