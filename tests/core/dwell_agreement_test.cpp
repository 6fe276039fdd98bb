#include "core/motion/dwell_agreement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace dwell {
namespace {

ElementEstimate element_with(double c, double u) {
  ElementEstimate element;
  element.k = 1;
  element.identifiable = true;
  element.stiffness = {c, u, 100.0, 2 * u, true};
  element.damping = {10.0, 0.1, 100.0, 0.2, true};
  element.budget = {{"noise of y1", 0.5, 0.5, SourceKind::noise, "y1"},
                    {"scale of y1", 0.5, 0.5, SourceKind::other, {}}};
  return element;
}

struct Pair {
  MotionEstimate motion;
  Dwell dwell;
};
Pair same_data(double c_motion, double c_dwell) {
  Pair out;
  out.motion.start_s = 0.0;
  out.motion.end_s = 10.0;
  out.motion.elements = {element_with(c_motion, 2.0)};
  out.motion.u_of_noise = {1.0, 0.05};
  out.dwell.start_s = 4.5;
  out.dwell.settled_s = 5.0;
  out.dwell.end_s = 10.0;
  out.dwell.elements = {element_with(c_dwell, 2.0)};
  return out;
}

// Variances by noise: 1 of the motion, 0.5 · 4 = 2 of the dwell; of the difference 2 - 1.
TEST(DwellAgreement, TakesTheDifferenceOfTheVariancesOfTheSameData) {
  const Pair pair = same_data(1000.0, 1003.0);
  EXPECT_NEAR(agreement_of(pair.motion, pair.dwell)->e_n, 3.0 / 2.0, 1e-9);
}

TEST(DwellAgreement, TakesTheirSumWhereTheDwellGoesOn) {
  Pair pair = same_data(1000.0, 1003.0);
  pair.dwell.end_s = 60.0;
  EXPECT_NEAR(agreement_of(pair.motion, pair.dwell)->e_n, 3.0 / (2.0 * std::sqrt(3.0)), 1e-9);
}

TEST(DwellAgreement, SaysNothingOfElementsThatOneOfBothLacks) {
  Pair pair = same_data(1000.0, 1003.0);
  pair.dwell.elements[0].identifiable = false;
  EXPECT_FALSE(agreement_of(pair.motion, pair.dwell));
}

// U of either is 4, of both 5.66; u of a difference by noise is 1 (stiffness) and 0.05 (damping, of U 0.2, 0.28).
TEST(DwellAgreement, NamesTheCoefficientThatContradicts) {
  Pair pair = same_data(1000.0, 1005.0);
  EXPECT_FALSE(agreement_of(pair.motion, pair.dwell)->contradicts) << "within the stated U of both";
  pair = same_data(1000.0, 1006.0);
  pair.dwell.elements.push_back(element_with(500.0, 2.0));
  pair.motion.elements.push_back(element_with(500.0, 2.0));
  pair.dwell.elements[1].k = pair.motion.elements[1].k = 2;
  pair.motion.u_of_noise.insert(pair.motion.u_of_noise.end(), {1.0, 0.05});
  Agreement agreement = *agreement_of(pair.motion, pair.dwell);
  EXPECT_TRUE(agreement.contradicts);
  EXPECT_EQ(agreement.element, 1);
  EXPECT_EQ(agreement.kind, CoefficientKind::stiffness);
  EXPECT_NEAR(agreement.over_U, 6.0 / std::hypot(4.0, 4.0), 1e-12);
  pair.dwell.elements[1].damping.value += 0.5;
  agreement = *agreement_of(pair.motion, pair.dwell);
  EXPECT_EQ(agreement.element, 2) << "it differs by more";
  EXPECT_EQ(agreement.kind, CoefficientKind::damping);
}

// Of two differences the largest is above 1.12 · 2 u by chance in 5 % of all cases: erfc(√2 · 1.12) = 0.05 / 2.
TEST(DwellAgreement, CallsNoContradictionWhatChanceExplains) {
  const auto contradicts = [](double e_n) {
    Pair pair = same_data(1000.0, 1000.0 + 2 * e_n);
    pair.motion.elements[0].stiffness.U95 = pair.dwell.elements[0].stiffness.U95 = 0.1;
    return agreement_of(pair.motion, pair.dwell)->contradicts;
  };
  EXPECT_FALSE(contradicts(1.73));
  EXPECT_TRUE(contradicts(1.75));
}

Pair contradicted(std::vector<double> moves) {
  Pair p = same_data(100.0, 100.0);
  p.motion.elements.clear();
  p.motion.contradicted = true;
  p.motion.reason = "the chain of the rig file does not explain y1";
  if (!moves.empty()) {
    p.motion.missing.resize(1);
    p.motion.missing[0].moves = std::move(moves);
  }
  return p;
}

TEST(ObjectionToADwell, IsGraveWhereNothingExplainsTheReadingsOrWhatDoesMovesACoefficientBeyondItsU95) {
  const Pair unexplained = contradicted({});
  const auto objection = objection_to(unexplained.dwell, unexplained.motion);
  ASSERT_TRUE(objection);
  EXPECT_EQ(objection->what, "any motion: the chain of the rig file does not explain y1");
  EXPECT_TRUE(objection->grave);
  const Pair stiffness = contradicted({-4.1, 0.0}), damping = contradicted({0.0, 0.21}),
             neither = contradicted({3.9, -0.19});
  EXPECT_TRUE(objection_to(stiffness.dwell, stiffness.motion)->grave);
  EXPECT_TRUE(objection_to(damping.dwell, damping.motion)->grave);
  EXPECT_FALSE(objection_to(neither.dwell, neither.motion)->grave);
}

// U of either is 4: five standard uncertainties of the difference are 2.5 √32 = 14.1.
TEST(ObjectionToADwell, IsThatACoefficientDiffersByFiveStandardUncertainties) {
  const Pair little = same_data(1000.0, 1014.0), much = same_data(1000.0, 1014.3);
  EXPECT_FALSE(objection_to(little.dwell, little.motion));
  const auto objection = objection_to(much.dwell, much.motion);
  ASSERT_TRUE(objection);
  EXPECT_TRUE(objection->grave);
  EXPECT_EQ(objection->elements, std::vector<int>{1});
  EXPECT_NE(objection->what.find("the stiffness of element 1 differs from this dwell's by 2.5 of the joint U"),
            std::string::npos)
      << objection->what;
}

TEST(ObjectionToADwell, NamesTheChannelsThatHarmonicsMayFoldIntoWhereTheMethodsContradict) {
  Pair pair = same_data(1000.0, 1014.3);
  pair.dwell.elements[0].budget.push_back({"folded harmonics of y1", 0.1, 0.1, SourceKind::folded_harmonics, "y1"});
  const auto objection = objection_to(pair.dwell, pair.motion);
  ASSERT_TRUE(objection);
  EXPECT_NE(objection->what.find(", or a harmonic of the drive folds onto the fundamental in y1"), std::string::npos)
      << objection->what;
}

TEST(ObjectionToADwell, IsThatANamedTermWouldMoveItsCoefficientsBeyondTheirU95) {
  Pair pair = contradicted({10.1, 0.0});
  pair.motion.contradicted = false;
  MissingTerm& term = pair.motion.missing[0];
  term.told = "a delay of y1 of 5.70 ± 0.20 ms";
  term.gain = 34.0;
  const auto objection = objection_to(pair.dwell, pair.motion);
  ASSERT_TRUE(objection);
  EXPECT_TRUE(objection->grave);
  EXPECT_EQ(objection->elements, std::vector<int>{1});
  EXPECT_EQ(objection->what,
            "any motion: the readings are better explained with a delay of y1 of 5.70 ± 0.20 ms (gain 34), which would "
            "move element 1 by more than U95");
  pair.motion.missing[0].moves = {9.9, 0.19};
  EXPECT_FALSE(objection_to(pair.dwell, pair.motion)->grave) << "beyond U95, but not by five standard uncertainties";
  pair.motion.missing[0].moves = {3.9, 0.19};
  EXPECT_FALSE(objection_to(pair.dwell, pair.motion));
}

// A weak spring to ground looks like a scale; the likelier of the two is chance, the other may be true.
TEST(ObjectionToADwell, CountsTermsThatTheReadingsDoNotTellFromTheLikeliest) {
  Pair pair = contradicted({3.9, 0.0});
  pair.motion.contradicted = false;
  pair.motion.missing.resize(2);
  pair.motion.missing[0].told = "a scale of y0 of 0.9965 ± 0.0022 instead of 1";
  pair.motion.missing[0].gain = 19.5;
  pair.motion.missing[1].told = "a spring of 7.1 ± 4.4 N/m from mass 1 to ground";
  pair.motion.missing[1].gain = 18.9;
  pair.motion.missing[1].moves = {4.1, 0.0};
  const auto objection = objection_to(pair.dwell, pair.motion);
  ASSERT_TRUE(objection);
  EXPECT_FALSE(objection->grave) << "beyond U95, but not by five standard uncertainties";
  EXPECT_EQ(objection->what,
            "any motion: the readings are better explained with a scale of y0 of 0.9965 ± 0.0022 instead of 1 or a "
            "spring of 7.1 ± 4.4 N/m from mass 1 to ground (gain 19.5 of the first): one or the other may move element "
            "1 by more than U95");
}

TEST(ObjectionToADwell, MayNameATermByTheTransientAlone) {
  Pair before = contradicted({10.1, 0.0});
  before.motion.end_s = 4.6;
  EXPECT_FALSE(objection_to(before.dwell, before.motion)) << "a knock in the transient contradicts the chain too";
  before.motion.contradicted = false;
  EXPECT_TRUE(objection_to(before.dwell, before.motion));
  before.motion.end_s = 4.4;
  EXPECT_FALSE(objection_to(before.dwell, before.motion)) << "of another hold";
}

constexpr const char* kPattern =
    "the readings of y0 err in a pattern, by 5.5 % of its motion or more. It is no noise, and the other channels show "
    "that the table does not move so. Hum does this, a register that is refreshed at another rate than it is read, "
    "wrong instants, or a transducer that distorts. The ± of this dwell does not cover it";

// How far the coefficients are off is not known, so none is doubted.
TEST(ObjectionToADwell, IsThatReadingsOfTheTableErrInAPatternWhichItsUncertaintyDoesNotCover) {
  Pair pair = same_data(1000.0, 1000.0);
  pair.motion.patterns = {{"y0", 0.055}};
  const auto objection = objection_to(pair.dwell, pair.motion);
  ASSERT_TRUE(objection);
  EXPECT_FALSE(objection->grave);
  EXPECT_TRUE(objection->elements.empty()) << "all";
  EXPECT_EQ(objection->what, std::string("any motion: ") + kPattern);
  pair.motion.patterns.push_back({"a0", 0.2});
  const std::string both = objection_to(pair.dwell, pair.motion)->what;
  EXPECT_NE(both.find("a transducer that distorts; the readings of a0 err in a pattern, by 20 % of its motion"),
            std::string::npos)
      << both;
}

TEST(ObjectionToADwell, NamesAPatternBesideWhatElseIsHeldAgainstTheDwell) {
  Pair much = same_data(1000.0, 1014.3);
  const std::string alone = objection_to(much.dwell, much.motion)->what;
  much.motion.patterns = {{"y0", 0.055}};
  const auto objection = objection_to(much.dwell, much.motion);
  EXPECT_TRUE(objection->grave);
  EXPECT_EQ(objection->elements, std::vector<int>{1});
  EXPECT_EQ(objection->what, alone + "; " + kPattern);
}

// A term without weight concerns its own elements, a pattern all of them. The warning stood at element 1 alone.
TEST(ObjectionToADwell, WarnsAllElementsOfAPatternBesideATermWithoutWeight) {
  Pair pair = contradicted({9.9, 0.19});
  pair.motion.contradicted = false;
  pair.motion.reason = "";
  pair.motion.missing[0].told = "a delay of y1 of 5.70 ± 0.20 ms";
  ASSERT_EQ(objection_to(pair.dwell, pair.motion)->elements, std::vector<int>{1});
  pair.motion.patterns = {{"y0", 0.055}};
  const auto objection = objection_to(pair.dwell, pair.motion);
  EXPECT_FALSE(objection->grave);
  EXPECT_TRUE(objection->elements.empty()) << "all";
}

// A wrong chain moves the table as it would need it, so its residuals tell nothing of the transducer.
TEST(ObjectionToADwell, IsNoPatternOfOtherDataOrOfAChainThatIsRefused) {
  Pair before = same_data(1000.0, 1000.0);
  before.motion.patterns = {{"y0", 0.055}};
  before.motion.end_s = 4.9;
  EXPECT_FALSE(objection_to(before.dwell, before.motion)) << "of the transient alone";
  Pair unfitted = same_data(1000.0, 1000.0), refused = contradicted({});
  unfitted.motion.patterns = refused.motion.patterns = {{"y0", 0.055}};
  unfitted.motion.reason = "the estimate did not converge in 60 passes";
  EXPECT_FALSE(objection_to(unfitted.dwell, unfitted.motion));
  EXPECT_EQ(objection_to(refused.dwell, refused.motion)->what,
            "any motion: the chain of the rig file does not explain y1");
}

TEST(ObjectionToADwell, IsNoneWhereOnlyTheReadingsAreTooFewOrTheDwellIsNotInTheStretch) {
  Pair few = contradicted({});
  few.motion.contradicted = false;
  EXPECT_FALSE(objection_to(few.dwell, few.motion));
  Pair later = contradicted({});
  later.motion.end_s = 4.0;
  EXPECT_FALSE(objection_to(later.dwell, later.motion));
}

}  // namespace
}  // namespace dwell
