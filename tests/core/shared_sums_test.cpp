// Sums of the modal fit, the normal matrix shared by channels that are read at the same instants.
#include "core/transient/shared_sums.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

namespace dwell {
namespace {

TEST(SharedSums, AreThoseOfTheProductsHoweverManySamplesThereAre) {
  constexpr Eigen::Index kMost = 7, kUsed = 5;
  for (int samples = 1; samples <= 13; ++samples) {
    std::mt19937_64 rng(static_cast<std::uint64_t>(samples));
    std::normal_distribution<double> normal;
    SharedSums sums(1, kMost);
    Eigen::MatrixXd normal_matrix = Eigen::MatrixXd::Zero(kUsed, kUsed);
    Eigen::VectorXd moments = Eigen::VectorXd::Zero(kUsed);
    double squares = 0.0, first = 0.0;
    for (int i = 0; i < samples; ++i) {
      Eigen::VectorXd x(kMost);
      for (double& each : x) each = normal(rng);
      const double value = 1e6 + normal(rng);
      if (i == 0) first = value;
      const Eigen::VectorXd used = x.head(kUsed);
      normal_matrix += used * used.transpose();
      moments += (value - first) * used;
      squares += (value - first) * (value - first);
      sums.add(0, static_cast<std::uint64_t>(i) + 1, x, kUsed, value);
    }
    sums.complete(0, kUsed);
    const ModalSums own = sums.of(0);
    EXPECT_EQ(sums.reference(0), first);
    EXPECT_EQ(own.samples(), samples);
    EXPECT_NEAR(own.squares(), squares, 1e-9);
    EXPECT_LT((own.moments().head(kUsed) - moments).norm(), 1e-9);
    for (Eigen::Index i = 0; i < kUsed; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) EXPECT_NEAR(own.normal()(i, j), normal_matrix(i, j), 1e-9);
  }
}

TEST(SharedSums, ClearedTheyTakeANewReference) {
  SharedSums sums(1, 2);
  sums.add(0, 1, Eigen::Vector2d{1.0, 2.0}, 2, 7.0);
  sums.clear();
  sums.add(0, 2, Eigen::Vector2d{1.0, 2.0}, 2, 9.0);
  sums.add(0, 3, Eigen::Vector2d{1.0, 0.0}, 2, 10.0);
  sums.complete(0, 2);
  EXPECT_EQ(sums.reference(0), 9.0);
  EXPECT_EQ(sums.of(0).samples(), 2.0);
  EXPECT_EQ(sums.of(0).moments()(0), 1.0);
  EXPECT_EQ(sums.of(0).normal()(0, 0), 2.0);
  EXPECT_EQ(sums.of(0).normal()(1, 0), 2.0);
}

// Shared sums, and beside them those of each channel by itself.
struct BesideEachOther {
  static constexpr int kChannels = 6;
  static constexpr Eigen::Index kMost = 9, kUsed = 8;
  SharedSums shared{kChannels, kMost};
  std::vector<SharedSums> alone = std::vector<SharedSums>(kChannels, SharedSums(1, kMost));
  std::mt19937_64 rng;
  std::uint64_t scan = 0;

  explicit BesideEachOther(std::uint64_t seed) : rng(seed) {}

  // A scan of the channels for which `has` says so, in any order.
  template <class Has>
  void play(Has&& has) {
    std::normal_distribution<double> normal;
    Eigen::VectorXd x(kMost);
    for (double& each : x) each = normal(rng);
    std::vector<int> order(kChannels);
    for (int c = 0; c < kChannels; ++c) order[static_cast<std::size_t>(c)] = c;
    std::shuffle(order.begin(), order.end(), rng);
    ++scan;
    for (const int c : order) {
      if (!has(c)) continue;
      const double value = 5 + normal(rng);
      shared.add(c, scan, x, kUsed, value);
      alone[static_cast<std::size_t>(c)].add(0, scan, x, kUsed, value);
    }
  }
  void complete() {
    for (int c = 0; c < kChannels; ++c) {
      shared.complete(c, kUsed);
      alone[static_cast<std::size_t>(c)].complete(0, kUsed);
    }
  }
  void expect_same() const {
    for (int c = 0; c < kChannels; ++c) {
      const ModalSums one = shared.of(c), other = alone[static_cast<std::size_t>(c)].of(0);
      EXPECT_EQ(one.samples(), other.samples()) << "channel " << c;
      EXPECT_EQ(one.squares(), other.squares()) << "channel " << c;
      EXPECT_EQ(one.moments().head(kUsed), other.moments().head(kUsed)) << "channel " << c;
      for (Eigen::Index j = 0; j < kUsed; ++j)
        EXPECT_EQ(one.normal().col(j).segment(j, kUsed - j), other.normal().col(j).segment(j, kUsed - j))
            << "channel " << c;
    }
  }
  [[nodiscard]] std::size_t groups() const {
    std::set<std::size_t> groups;
    for (int c = 0; c < kChannels; ++c) groups.insert(shared.group(c));
    return groups.size();
  }
};

TEST(SharedSums, AreThoseOfEachChannelByItselfWhateverItMisses) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    BesideEachOther both(seed);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    // From channels that miss hardly a scan to channels that are seldom there, or never.
    std::vector<double> present(BesideEachOther::kChannels);
    for (double& p : present) p = part(both.rng) < 0.3 ? part(both.rng) : 1 - 0.05 * part(both.rng);
    if (seed % 7 == 0) present[0] = 0.0;
    for (int again = 0; again < 2; ++again) {
      both.shared.clear();
      for (SharedSums& sums : both.alone) sums.clear();
      for (int stretch = 0; stretch < 3; ++stretch) {  // sums are read, and go on
        const int scans = std::uniform_int_distribution<int>(1, 30)(both.rng);
        for (int i = 0; i < scans; ++i)
          both.play([&](int c) { return part(both.rng) < present[static_cast<std::size_t>(c)]; });
        both.complete();
        both.expect_same();
      }
    }
  }
}

TEST(SharedSums, ChannelsOfAScanShareAMatrix) {
  BesideEachOther both(1);
  for (int i = 0; i < 9; ++i) both.play([](int) { return true; });
  both.complete();
  EXPECT_EQ(both.groups(), 1U);
}

TEST(SharedSums, TwoDevicesHaveAMatrixEachThoughTheyAreReadInTurn) {
  BesideEachOther both(2);
  for (int i = 0; i < 9; ++i) {
    both.play([](int c) { return c < 2; });
    both.play([](int c) { return c >= 2; });
  }
  both.complete();
  both.expect_same();
  EXPECT_EQ(both.groups(), 2U);
  EXPECT_EQ(both.shared.group(0), both.shared.group(1));
  EXPECT_EQ(both.shared.group(2), both.shared.group(5));
}

TEST(SharedSums, WhoMissesAScanHasAMatrixOfItsOwnFromThenOn) {
  BesideEachOther both(3);
  for (int i = 0; i < 9; ++i) both.play([&](int c) { return c != 4 || i != 6; });
  both.complete();
  both.expect_same();
  EXPECT_EQ(both.groups(), 2U);
  EXPECT_EQ(both.shared.of(4).samples(), 8.0);
}

TEST(SharedSums, AreWholeInTheMiddleOfAScan) {
  BesideEachOther both(4);
  for (int i = 0; i < 9; ++i) both.play([](int) { return true; });
  both.play([](int c) { return c < 3; });
  both.complete();
  both.expect_same();
  --both.scan;  // the rest of it, whose regressors may be the same
  both.play([](int c) { return c >= 3; });
  both.complete();
  both.expect_same();
}

}  // namespace
}  // namespace dwell
