// Limits are decided by the whole 95 % interval (ISO 14253-1), and only of numbers that may be relied on.
#include "core/rig/limit.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

LimitVerdict judged(double value, double U95) {
  return judge_limit({7500.0, 8500.0}, {value, U95 / 2, 100.0, U95, true});
}

// One mass between two elements, measured; the second element's stiffness is limited, then its damping.
struct LimitTest : testing::Test {
  LimitTest() {
    rig.masses = {1.0};
    rig.boundary = Boundary::clamped;
    rig.limits = {{2, Bounds{7500.0, 8500.0}, Bounds{40.0, 50.0}}};
    dwell.settled_s = 3.0;
    dwell.elements.resize(2);
    for (int k = 1; k <= 2; ++k) {
      ElementEstimate& e = dwell.elements[static_cast<std::size_t>(k - 1)];
      e.k = k;
      e.identifiable = true;
      e.stiffness = {8000.0, 50.0, 100.0, 100.0, true};
      e.damping = {52.0, 0.5, 100.0, 1.0, true};
    }
  }
  void expect_none(const std::string& reason) const {
    for (const JudgedLimit& limit : judge_limits(rig, dwell)) {
      EXPECT_EQ(limit.verdict, LimitVerdict::none);
      EXPECT_EQ(limit.reason, reason);
    }
  }
  Rig rig;
  Dwell dwell;
};

TEST(LimitVerdicts, AreOfTheWholeInterval) {
  EXPECT_EQ(judged(8000.0, 100.0), LimitVerdict::kept);
  EXPECT_EQ(judged(8000.0, 500.0), LimitVerdict::kept);
  EXPECT_EQ(judged(8450.0, 100.0), LimitVerdict::undecided);
  EXPECT_EQ(judged(8550.0, 100.0), LimitVerdict::undecided);
  EXPECT_EQ(judged(8000.0, 2000.0), LimitVerdict::undecided);
  EXPECT_EQ(judged(8650.0, 100.0), LimitVerdict::violated);
  EXPECT_EQ(judged(7350.0, 100.0), LimitVerdict::violated);
  EXPECT_EQ(judge_limit({7500.0, INFINITY}, {.value = 1e9, .U95 = 1.0}), LimitVerdict::kept);
  EXPECT_EQ(judge_limit({7500.0, INFINITY}, {.value = 7000.0, .U95 = 1.0}), LimitVerdict::violated);
  EXPECT_EQ(judge_limit({-INFINITY, 8500.0}, {.value = 8500.0, .U95 = 1.0}), LimitVerdict::undecided);
}

TEST(LimitVerdicts, ThereAreNoneWithoutANumber) {
  EXPECT_EQ(judged(kNaN, 100.0), LimitVerdict::none);
  EXPECT_EQ(judged(8000.0, kNaN), LimitVerdict::none);
}

TEST_F(LimitTest, EachCoefficientIsJudgedByItsOwnLimit) {
  const auto limits = judge_limits(rig, dwell);
  ASSERT_EQ(limits.size(), 2u);
  EXPECT_EQ(limits[0].kind, CoefficientKind::stiffness);
  EXPECT_EQ(limits[0].verdict, LimitVerdict::kept);
  EXPECT_EQ(limits[1].kind, CoefficientKind::damping);
  EXPECT_EQ(limits[1].element, 2);
  EXPECT_EQ(limits[1].verdict, LimitVerdict::violated);
  EXPECT_EQ(limits[1].reason, "");
}

TEST_F(LimitTest, WithoutASettledDwellThereIsNoVerdict) {
  dwell.settled_s = kNaN;
  expect_none("not settled");
}

TEST_F(LimitTest, OfAWithheldElementTheReasonStandsInPlaceOfTheVerdict) {
  dwell.elements[1].identifiable = false;
  dwell.elements[1].reason = "y2 is stale";
  expect_none("y2 is stale");
}

TEST_F(LimitTest, ANumberThatMustNotBeReliedOnIsNotJudged) {
  dwell.doubts = {{{2}, "the poles contradict the chain"}};
  expect_none("the number must not be relied on: the poles contradict the chain");
  dwell.doubts = {{{1}, "r_1 is negative"}};
  EXPECT_EQ(judge_limits(rig, dwell)[1].verdict, LimitVerdict::violated);
}

TEST_F(LimitTest, OfTheCurrentDwellThereIsAVerdictOnlyWhileItIsMeasured) {
  dwell.state = State::measuring;
  EXPECT_EQ(judge_limits_now(rig, dwell)[0].verdict, LimitVerdict::kept);
  EXPECT_EQ(judge_limits_now(rig, dwell)[1].verdict, LimitVerdict::violated);
  const auto expect_none_now = [this](State state, const std::string& reason) {
    dwell.state = state;
    for (const JudgedLimit& limit : judge_limits_now(rig, dwell)) {
      EXPECT_EQ(limit.verdict, LimitVerdict::none) << to_string(state);
      EXPECT_EQ(limit.reason, reason);
    }
    EXPECT_EQ(judge_limits(rig, dwell)[0].verdict, LimitVerdict::kept) << "a finished dwell keeps its verdicts";
  };
  expect_none_now(State::complete, "the dwell has ended");
  expect_none_now(State::fault, "the data do not suffice");
  expect_none_now(State::settling, "not settled");
  dwell.doubts = {{{}, "the table moved"}};
  for (const JudgedLimit& limit : judge_limits_now(rig, dwell))
    EXPECT_EQ(limit.reason, "the number must not be relied on: the table moved");
}

}  // namespace
}  // namespace dwell
