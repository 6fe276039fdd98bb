#include "core/drive/drive_doubt.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

void look(DriveDoubt& doubt, bool amplitude, bool phase) {
  doubt.begin(false);
  doubt.see(amplitude, phase, false);
  doubt.end();
}

TEST(DriveDoubt, IsAsLongAsTheLooksInARowThatDoubt) {
  DriveDoubt doubt;
  for (int i = 1; i <= 5; ++i) {
    look(doubt, true, false);
    EXPECT_EQ(doubt.quarters(), i);
    EXPECT_EQ(doubt.amplitude(), i);
  }
  look(doubt, false, false);
  EXPECT_EQ(doubt.quarters(), 0);
}

TEST(DriveDoubt, APhaseThatSlipsForLongIsADriftAndNoDoubt) {
  DriveDoubt doubt;
  for (int i = 1; i <= 8; ++i) {
    look(doubt, false, true);
    EXPECT_EQ(doubt.quarters(), i);
    EXPECT_EQ(doubt.amplitude(), 0);
  }
  look(doubt, false, true);
  EXPECT_EQ(doubt.quarters(), 0) << "two periods have gone";
  look(doubt, true, true);
  EXPECT_EQ(doubt.quarters(), 1) << "the amplitude is another matter";
}

TEST(DriveDoubt, WhatLiesFarBackStandsUntilTheNextFarLook) {
  DriveDoubt doubt;
  doubt.begin(true);
  doubt.see(true, false, true);
  doubt.end();
  EXPECT_EQ(doubt.quarters(), 1);
  look(doubt, false, false);
  EXPECT_EQ(doubt.quarters(), 2) << "near looks do not see so far";
  doubt.begin(true);
  doubt.end();
  EXPECT_EQ(doubt.quarters(), 0);
}

TEST(DriveDoubt, OneSightOfALookIsEnough) {
  DriveDoubt doubt;
  doubt.begin(false);
  doubt.see(false, true, false);
  doubt.see(false, false, false);
  doubt.end();
  EXPECT_EQ(doubt.quarters(), 1);
  doubt.restart();
  EXPECT_EQ(doubt.quarters(), 0);
}

}  // namespace
}  // namespace dwell
