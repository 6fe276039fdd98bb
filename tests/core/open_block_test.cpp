#include "core/fit/open_block.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <utility>
#include <vector>

namespace dwell {
namespace {

constexpr int kBlockHarmonics = 2, kInstantAngles = 2 * kBlockHarmonics + 1, kReadingAngles = kBlockHarmonics + 1;
constexpr double kBlockOmega = 2 * M_PI;

// Moments as their definition has them, of (instant in s from the centre, reading).
using Samples = std::vector<std::pair<double, double>>;
void expect_moments(const double* instants, const double* readings, const Samples& samples) {
  for (int k = 0; k < kInstantAngles; ++k) {
    std::complex<double> m0, m1, z0, z1;
    double uu = 0.0, ss = 0.0;
    for (const auto& [u, s] : samples) {
      const auto turn = std::polar(1.0, k * kBlockOmega * u);
      m0 += turn, m1 += u * turn, z0 += s * turn, z1 += s * u * turn;
      uu += u * u, ss += s * s;
    }
    EXPECT_NEAR(instants[moments::cosine(kInstantAngles, 0, k)], m0.real(), 1e-12) << k;
    EXPECT_NEAR(instants[moments::sine(kInstantAngles, 0, k)], m0.imag(), 1e-12) << k;
    EXPECT_NEAR(instants[moments::cosine(kInstantAngles, 1, k)], m1.real(), 1e-12) << k;
    EXPECT_NEAR(instants[moments::squares(kInstantAngles)], uu, 1e-12);
    if (k >= kReadingAngles) continue;
    EXPECT_NEAR(readings[moments::cosine(kReadingAngles, 0, k)], z0.real(), 1e-12) << k;
    EXPECT_NEAR(readings[moments::sine(kReadingAngles, 0, k)], z0.imag(), 1e-12) << k;
    EXPECT_NEAR(readings[moments::cosine(kReadingAngles, 1, k)], z1.real(), 1e-12) << k;
    EXPECT_NEAR(readings[moments::squares(kReadingAngles)], ss, 1e-12);
  }
}

// Quarter blocks of three channels about 0.
struct Filled {
  void open() { block.open(sets, slot, 0, 125'000'000, kBlockOmega); }
  void add(int channel, double u, double value) {
    const std::int64_t t_ns = std::llround(1e9 * u);
    block.add(channel, t_ns, value);
    seen[static_cast<std::size_t>(channel)].emplace_back(1e-9 * static_cast<double>(t_ns),
                                                         value - block.reference(channel));
  }
  void close() {
    block.close(sets);
    for (int c = 0; c < 3; ++c)
      expect_moments(sets.shared_instants(slot, c), sets.readings(slot, c), seen[static_cast<std::size_t>(c)]);
    for (Samples& each : seen) each.clear();
    ++slot;
  }
  // What it holds so far.
  void expect_so_far() {
    Totals totals(3, kBlockHarmonics);
    totals.restart(kBlockOmega, 0);
    block.add_to(totals, totals.turn_from(kBlockOmega, 0));
    for (int c = 0; c < 3; ++c) {
      const ChannelMoments channel = totals.channel(c);
      expect_moments(channel.instants, channel.readings, seen[static_cast<std::size_t>(c)]);
    }
  }
  [[nodiscard]] int owner(int channel) const { return sets.owner(slot - 1, channel); }

  MomentSets sets{8, 3, kBlockHarmonics};
  OpenBlock block{3, kBlockHarmonics};
  std::size_t slot = 0;
  std::vector<Samples> seen{3};
};

// A block in which channels 0 … read at the same instants.
void fill_together(Filled& filled) {
  filled.open();
  for (int i = -10; i < 10; ++i)
    for (int c = 0; c < 3; ++c) filled.add(c, 0.01 * i, std::sin(i + c));
}

TEST(OpenBlock, HoldsTheMomentsOfItsSamples) {
  Filled filled;
  filled.block.set_reference(1, 5.0);
  filled.open();
  EXPECT_TRUE(filled.block.is_open());
  for (int i = -10; i < 10; ++i) {
    filled.add(0, 0.011 * i, std::sin(i));
    filled.add(1, 0.011 * i + 0.003, 5.0 + std::cos(i));
  }
  filled.close();
  EXPECT_FALSE(filled.block.is_open());
}

TEST(OpenBlock, ChannelsReadTogetherShareFromTheNextBlockOn) {
  Filled filled;
  fill_together(filled);
  filled.close();
  for (int c = 0; c < 3; ++c) EXPECT_EQ(filled.owner(c), c) << "not known yet";
  fill_together(filled);
  filled.close();
  for (int c = 0; c < 3; ++c) EXPECT_EQ(filled.owner(c), 0);
}

TEST(OpenBlock, AChannelThatMissesAnInstantGoesOnAlone) {
  for (int missing = 0; missing < 3; ++missing) {
    Filled filled;
    fill_together(filled);
    filled.close();
    filled.open();
    for (int i = -10; i < 10; ++i)
      for (int c = 0; c < 3; ++c)
        if (c != missing || i != 2) filled.add(c, 0.01 * i, std::sin(i + c));
    filled.close();
    EXPECT_EQ(filled.owner(missing), missing);
    const int one = (missing + 1) % 3, other = (missing + 2) % 3;
    EXPECT_EQ(filled.owner(one), filled.owner(other)) << "the others go on together";
    EXPECT_NE(filled.owner(one), missing);
  }
}

TEST(OpenBlock, OneThatMissesTheLastInstantIsSeenAtTheClose) {
  Filled filled;
  fill_together(filled);
  filled.close();
  fill_together(filled);
  filled.add(0, 0.1, 1.0);
  filled.add(2, 0.1, 3.0);
  filled.close();
  EXPECT_EQ(filled.owner(1), 1);
  EXPECT_EQ(filled.owner(2), 0);
}

TEST(OpenBlock, WhatItHoldsSoFarIsRightAmidAnInstant) {
  Filled filled;
  fill_together(filled);
  filled.close();
  fill_together(filled);
  filled.expect_so_far();
  filled.add(0, 0.1, 1.0);  // the others have not got it yet
  filled.expect_so_far();
  filled.add(1, 0.1, 2.0);
  filled.expect_so_far();
  filled.add(2, 0.1, 3.0);
  filled.expect_so_far();
}

TEST(OpenBlock, AResetForgetsWhoShares) {
  Filled filled;
  fill_together(filled);
  filled.close();
  filled.block.reset();
  fill_together(filled);
  filled.close();
  for (int c = 0; c < 3; ++c) EXPECT_EQ(filled.owner(c), c);
}

}  // namespace
}  // namespace dwell
