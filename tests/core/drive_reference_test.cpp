// What the drive's frequency is known from beside the motion, and what contradicts it.
#include "core/drive/drive_reference.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

Rig reference_rig(Reference kind) {
  Rig rig;
  rig.excitation.reference = kind;
  rig.excitation.frequency_hz = 4.0;
  rig.excitation.frequency_u_hz = 1e-3;
  rig.excitation.clock_u = 0.0;
  rig.excitation.search_low_hz = 3.9;
  rig.excitation.search_high_hz = 4.1;
  return rig;
}

// So many pulses of that frequency from t = 0; the instant of the last, ns.
std::int64_t pulses(DriveReference& reference, double f_hz, int count) {
  std::int64_t t_ns = 0;
  for (int k = 0; k < count; ++k) {
    t_ns = std::llround(1e9 * k / f_hz);
    reference.pulse(t_ns);
  }
  return t_ns;
}

TEST(DriveReference, ATrackedDriveNeedsNothingButItsMotion) {
  const Rig rig = reference_rig(Reference::tracked);
  DriveReference reference(rig);
  pulses(reference, 5.0, 40);
  EXPECT_TRUE(reference.inexact() && reference.from_motion());
  EXPECT_TRUE(reference.usable(0));
  EXPECT_FALSE(reference.lost(0));
  EXPECT_EQ(reference.unusable_reason(0), "");
  EXPECT_FALSE(reference.pulses_contradict(kTwoPi * 4.0)) << "pulses are not heeded";
}

TEST(DriveReference, AnExactlyStatedFrequencyIsNotTracked) {
  Rig rig = reference_rig(Reference::fixed);
  EXPECT_TRUE(DriveReference(rig).inexact()) << "stated with an uncertainty: a prior";
  rig.excitation.frequency_u_hz = 0.0;
  EXPECT_FALSE(DriveReference(rig).inexact());
}

TEST(DriveReference, BySyncADwellBeginsOnlyWhilePulsesComeWithinTheRangeSearched) {
  const Rig rig = reference_rig(Reference::sync);
  DriveReference reference(rig);
  EXPECT_FALSE(reference.usable(0));
  EXPECT_EQ(reference.unusable_reason(0),
            "no sync pulse seen yet: expected one for each period of the drive; check the sync input");
  const std::int64_t last_ns = pulses(reference, 4.0, 40);
  EXPECT_TRUE(reference.usable(last_ns + 1));
  const std::int64_t later_ns = last_ns + 3'000'000'000;
  EXPECT_TRUE(reference.lost(later_ns));
  EXPECT_EQ(reference.unusable_reason(later_ns), "no sync pulse for 3.00 s");
  EXPECT_FALSE(reference.from_motion());
}

TEST(DriveReference, ATableTwoTolerancesOffThePulsesContradictsThem) {
  const Rig rig = reference_rig(Reference::sync);
  DriveReference reference(rig);
  pulses(reference, 4.0, 40);
  EXPECT_FALSE(reference.pulses_contradict(kTwoPi * 4.0 * (1 + 1.9 * rig.tolerance)));
  EXPECT_TRUE(reference.pulses_contradict(kTwoPi * 4.0 * (1 + 2.1 * rig.tolerance)));
  EXPECT_FALSE(reference.pulses_contradict(kNaN)) << "not known yet";
  EXPECT_NE(reference.contradiction_of_pulses(kTwoPi * 4.08).find("moves at 4.08"), std::string::npos);
}

TEST(DriveReference, DataFourStandardDeviationsOffTheStatementGiveNoCoefficients) {
  const Rig rig = reference_rig(Reference::fixed);
  const DriveReference reference(rig);
  const HarmonicFit table;
  Refined refined{.omega = kTwoPi * 4.0, .data_omega = kTwoPi * 4.0039, .u_data = 0.0};
  EXPECT_EQ(reference.unfit_reason(refined, table, refined.omega, 0.0, 0.0), "");
  refined.data_omega = kTwoPi * 4.0041;
  EXPECT_NE(reference.unfit_reason(refined, table, refined.omega, 0.0, 0.0).find("says fixed at 4 "), std::string::npos)
      << reference.unfit_reason(refined, table, refined.omega, 0.0, 0.0);
  EXPECT_EQ(reference.unfit_reason(refined, table, refined.omega, 0.0, kTwoPi * 0.01), "")
      << "instants that are not known make the frequency uncertain";
}

TEST(DriveReference, MissedPulsesAreToldOfThisHoldAlone) {
  const Rig rig = reference_rig(Reference::sync);
  DriveReference reference(rig);
  const std::int64_t last_ns = pulses(reference, 4.0, 40);
  EXPECT_EQ(reference.missed(), "");
  reference.pulse(last_ns + 500'000'000);
  EXPECT_NE(reference.missed().find("1 missed"), std::string::npos) << reference.missed();
  reference.begin_hold();
  EXPECT_EQ(reference.missed(), "");
}

}  // namespace
}  // namespace dwell
