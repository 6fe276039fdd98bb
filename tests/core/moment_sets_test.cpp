#include "core/fit/moment_sets.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell {
namespace {

constexpr int kAngles = 3;  // of the instants, at one harmonic

// One sample of a channel at angle and time zero of its slot, with this reading.
void put(MomentSets& sets, std::size_t slot, int channel, double reading) {
  moments::Regressors now;
  moments::evaluate<1>(0.0, 0.0, now);
  if (sets.owner(slot, channel) == channel) moments::add<3>(now, 1.0, 0.0, sets.instants(slot, channel));
  moments::add<2>(now, reading, reading * reading, sets.readings(slot, channel));
}

TEST(MomentSets, AClearedSlotIsEmptyAndSharesNothing) {
  MomentSets sets(2, 3, 1);
  sets.clear(0);
  put(sets, 0, 0, 2.0);
  sets.share(0, 2, 0);
  sets.clear(0);
  for (int c = 0; c < 3; ++c) {
    sets.clear_instants(0, c);
    EXPECT_EQ(sets.owner(0, c), c);
    EXPECT_EQ(sets.shared_instants(0, c)[0], 0.0);
    EXPECT_EQ(sets.readings(0, c)[0], 0.0);
  }
}

TEST(MomentSets, SlotsAndChannelsDoNotTouchEachOther) {
  MomentSets sets(2, 2, 1);
  sets.clear(0);
  sets.clear(1);
  put(sets, 1, 0, 2.0);
  EXPECT_EQ(sets.readings(1, 0)[0], 2.0);
  EXPECT_EQ(sets.readings(1, 1)[0], 0.0);
  EXPECT_EQ(sets.readings(0, 0)[0], 0.0);
  EXPECT_EQ(sets.shared_instants(0, 0)[0], 0.0);
}

TEST(MomentSets, WhoSharesSeesTheOwnersInstants) {
  MomentSets sets(1, 2, 1);
  sets.clear(0);
  sets.share(0, 1, 0);
  put(sets, 0, 0, 2.0);
  put(sets, 0, 1, 3.0);
  EXPECT_EQ(sets.shared_instants(0, 1), sets.shared_instants(0, 0));
  EXPECT_EQ(sets.shared_instants(0, 1)[0], 1.0);
  EXPECT_EQ(sets.readings(0, 1)[0], 3.0);
}

TEST(MomentSets, AJoinedSlotHoldsBothPartsTurnedToItsCentre) {
  MomentSets sets(3, 1, 1);
  sets.clear(0);
  sets.clear(1);
  put(sets, 0, 0, 2.0);
  put(sets, 1, 0, 3.0);
  // The parts lie half a second before and after the new centre, a quarter turn each.
  sets.join({0, {0.0, -M_PI / 2, -0.5, kAngles}}, {1, {0.0, M_PI / 2, 0.5, kAngles}}, 2);
  const double* instants = sets.shared_instants(2, 0);
  EXPECT_EQ(instants[0], 2.0);
  EXPECT_NEAR(instants[moments::cosine(kAngles, 1, 0)], 0.0, 1e-15);
  EXPECT_NEAR(instants[moments::squares(kAngles)], 0.5, 1e-15);
  const double* readings = sets.readings(2, 0);
  EXPECT_NEAR(readings[moments::cosine(2, 0, 0)], 5.0, 1e-15);
  EXPECT_NEAR(readings[moments::sine(2, 0, 1)], 1.0, 1e-15) << "-2 + 3";
  EXPECT_NEAR(readings[moments::cosine(2, 1, 0)], 0.5, 1e-15) << "(3 - 2) / 2";
  EXPECT_NEAR(readings[moments::squares(2)], 13.0, 1e-15);
}

TEST(MomentSets, WhatIsSharedInBothPartsStaysSharedAndElseIsItsOwn) {
  MomentSets sets(3, 3, 1);
  sets.clear(0);
  sets.clear(1);
  sets.share(0, 1, 0);
  sets.share(1, 1, 0);
  sets.share(1, 2, 0);
  for (const std::size_t slot : {0u, 1u})
    for (int c = 0; c < 3; ++c) put(sets, slot, c, 1.0);
  const moments::Turn none{0.0, 0.0, 0.0, kAngles};
  sets.join({0, none}, {1, none}, 2);
  EXPECT_EQ(sets.owner(2, 1), 0);
  EXPECT_EQ(sets.owner(2, 2), 2);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(sets.shared_instants(2, c)[0], 2.0) << c;
}

}  // namespace
}  // namespace dwell
