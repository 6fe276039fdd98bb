// The tracker of the drive: does the table move, and as in this hold?
#include "core/drive/drive_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.hpp"
#include "core/drive/window_length.hpp"

namespace dwell {
namespace {

constexpr double kTrackedHz = 4.0, kTrackedU = 1e-6, kTrackedAmplitude = 1e-3;
constexpr DriveTracker::During kAtRest{}, kWhileSettling{true, false, false}, kWhileMeasuring{true, true, true};

Rig tracked_rig(Reference kind) {
  Rig rig;
  rig.excitation.reference = kind;
  rig.excitation.frequency_hz = kTrackedHz;
  rig.excitation.search_low_hz = 3.9;
  rig.excitation.search_high_hz = 4.1;
  rig.excitation.minimum = 1e-5;
  rig.excitation.clock_u = 0.0;
  return rig;
}

// A tracker, and windows of a table that moves at f Hz, a quarter of a period apart.
struct TrackedTable {
  explicit TrackedTable(Reference kind = Reference::tracked) : rig(tracked_rig(kind)) {}

  // The next window, of that amplitude and f; ahead_rad: of the phase so far; u: of either component.
  void move(double amplitude, double f_hz, double ahead_rad = 0.0, double u = kTrackedU) {
    centre_ns += std::llround(0.25e9 / f_hz);
    const double phase = kTwoPi * f_hz * 1e-9 * static_cast<double>(centre_ns);
    Y = std::polar(amplitude, phase);
    fit = {};
    fit.usable = true;
    fit.samples = 100.0;
    fit.X[0] = Y * std::polar(1.0, ahead_rad);
    fit.covariance = u * u * Eigen::Matrix2d::Identity();
    fit.sigma2 = u * u * fit.samples / 2;
    omega = kTwoPi * f_hz;
  }
  DriveTracker::Sight see(const DriveTracker::During& during) { return tracker.see({centre_ns, fit, Y}, NAN, during); }
  bool changed(const DriveTracker::During& during) {
    static_cast<void>(see(during));
    return tracker.changed({centre_ns, fit, Y}, 1e-9 * static_cast<double>(centre_ns), 0.0, omega, during);
  }
  // So many windows of the drive as it is; whether any of them showed a change.
  bool hold(int windows, double f_hz = kTrackedHz) {
    bool any = false;
    for (int i = 0; i < windows; ++i) {
      move(kTrackedAmplitude, f_hz);
      any = changed(kWhileSettling) || any;
    }
    return any;
  }
  // The data so far are those that count.
  void count() { tracker.refer({centre_ns, fit, kTrackedAmplitude, omega, 1e-6, 0.0, 0.0}, SamplingRegularity{}); }

  Rig rig;
  DriveReference reference{rig};
  DriveTracker tracker{rig, reference};
  HarmonicFit fit;
  std::complex<double> Y;
  std::int64_t centre_ns = 0;
  double omega = 0.0;
};

TEST(DriveTracker, ATableBelowTheMinimumRestsInItsSecondWindow) {
  TrackedTable table;
  table.move(0.9e-5, kTrackedHz, 0.0, 1e-8);
  EXPECT_EQ(table.see(kWhileSettling), DriveTracker::Sight::low);
  EXPECT_EQ(table.see(kWhileSettling), DriveTracker::Sight::rests);
  table.move(1.1e-5, kTrackedHz, 0.0, 1e-8);
  EXPECT_EQ(table.see(kAtRest), DriveTracker::Sight::moves);
  table.move(0.9e-5, kTrackedHz, 0.0, 1e-8);
  EXPECT_EQ(table.see(kWhileSettling), DriveTracker::Sight::low) << "counted anew";
}

TEST(DriveTracker, WhatNoiseMightBeTakenForIsFaintAndBelowThreeStandardDeviationsNoDrive) {
  TrackedTable table;
  for (const auto& [deviations, sight] :
       {std::pair{6.0, DriveTracker::Sight::moves}, std::pair{4.0, DriveTracker::Sight::faint},
        std::pair{2.5, DriveTracker::Sight::low}}) {
    table.move(deviations * 1e-4, kTrackedHz, 0.0, 1e-4);
    EXPECT_EQ(table.see(kAtRest), sight) << deviations;
  }
}

TEST(DriveTracker, ATableThatMovesAtAMultipleOfTheWindowsFrequencyAloneDoesNotRest) {
  TrackedTable table;
  table.move(1e-7, kTrackedHz);
  const DriveTracker::Window octave{table.centre_ns, table.fit, table.Y, kTrackedAmplitude};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(table.tracker.see(octave, NAN, kWhileSettling), DriveTracker::Sight::elsewhere);
  const DriveTracker::Window noise{table.centre_ns, table.fit, table.Y, 0.9e-5};
  EXPECT_EQ(table.tracker.see(noise, NAN, kWhileSettling), DriveTracker::Sight::low);
  EXPECT_EQ(table.tracker.see(noise, NAN, kWhileSettling), DriveTracker::Sight::rests);
}

TEST(DriveTracker, OneBadReadingWhileMeasuringIsNoStop) {
  TrackedTable table;
  table.hold(20);
  table.count();
  table.move(0.5 * kTrackedAmplitude, kTrackedHz, 0.0, kTrackedAmplitude);
  EXPECT_EQ(table.see(kWhileMeasuring), DriveTracker::Sight::faint);
  table.move(0.2 * kTrackedAmplitude, kTrackedHz, 0.0, kTrackedAmplitude);
  EXPECT_EQ(table.see(kWhileMeasuring), DriveTracker::Sight::low) << "less than a quarter of what it was";
}

TEST(DriveTracker, ASteadyDriveIsTheSameAndItsFrequencyIsThatOfItsPhase) {
  TrackedTable table;
  EXPECT_TRUE(std::isnan(table.tracker.omega()));
  EXPECT_FALSE(table.hold(40));
  EXPECT_NEAR(table.tracker.omega(), kTwoPi * kTrackedHz, 1e-6);
  EXPECT_EQ(table.tracker.doubtful_quarters(), 0);
  EXPECT_EQ(table.tracker.quarters_of_change(), 2);
}

TEST(DriveTracker, AnotherAmplitudeIsAnotherDriveInItsSecondWindow) {
  TrackedTable table;
  table.hold(20);
  table.move(1.1 * kTrackedAmplitude, kTrackedHz);
  EXPECT_FALSE(table.changed(kWhileSettling));
  table.move(1.1 * kTrackedAmplitude, kTrackedHz);
  EXPECT_TRUE(table.changed(kWhileSettling));
  EXPECT_GE(table.tracker.quarters_of_change(), 4);
}

TEST(DriveTracker, APhaseThatLeavesThatOfTheDataThatCountIsAnotherDriveInItsSecondWindow) {
  TrackedTable table;
  table.hold(20);
  table.count();
  table.move(kTrackedAmplitude, kTrackedHz, 0.15);
  EXPECT_FALSE(table.changed(kWhileMeasuring));
  table.move(kTrackedAmplitude, kTrackedHz, 0.15);
  EXPECT_TRUE(table.changed(kWhileMeasuring));
  table.tracker.stop_counting();
  table.move(kTrackedAmplitude, kTrackedHz, 0.15);
  EXPECT_FALSE(table.changed(kWhileSettling)) << "nothing counts that it could be held against";
}

TEST(DriveTracker, AHoldBeginsWithoutWhatWasSeenBefore) {
  TrackedTable table;
  table.hold(20);
  table.tracker.begin_hold();
  EXPECT_TRUE(std::isnan(table.tracker.omega()));
  EXPECT_FALSE(table.hold(20, 4.05)) << "another frequency, but the same since the hold began";
}

TEST(DriveTracker, ATrackedDriveBeyondTheSearchIsOutOfItAndAStatedOneContradictsItsStatement) {
  TrackedTable tracked, fixed(Reference::fixed);
  tracked.hold(20, 4.2);
  fixed.hold(20, 4.2);
  EXPECT_TRUE(tracked.tracker.out_of_search());
  EXPECT_FALSE(fixed.tracker.out_of_search());
}

TEST(WindowLength, IsTwoPeriodsForGoodOnceOneHadTooFewSamples) {
  WindowLength length;
  EXPECT_EQ(length.periods(), 1);
  length.not_fitted(true);
  EXPECT_EQ(length.periods(), 2);
  EXPECT_FALSE(length.too_few());
  length.fitted();
  EXPECT_EQ(length.periods(), 2);
}

TEST(WindowLength, HasTooFewSamplesOnlyWhereTwoPeriodsHaveSomeAndUntilTheyHaveEnough) {
  WindowLength length;
  length.lengthen();
  length.not_fitted(false);
  EXPECT_FALSE(length.too_few()) << "there are none: the channel is lost, not sparse";
  length.not_fitted(true);
  EXPECT_TRUE(length.too_few());
  length.fitted();
  EXPECT_EQ(length.kind(), WindowLength::Kind::two_periods);
}

}  // namespace
}  // namespace dwell
