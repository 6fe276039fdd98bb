#include "daemon/ctl/result_comparison.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace dwell::ctl {
namespace {

Difference only(const char* stored, const char* replayed) {
  const auto seen = compare_results(stored, replayed);
  EXPECT_TRUE(seen);
  if (!seen || seen->differences.size() != 1) {
    ADD_FAILURE() << (seen ? seen->differences.size() : 0) << " differences";
    return {};
  }
  return seen->differences[0];
}

TEST(ResultComparison, OfEqualTextsNothingDiffersAndTheOrderOfMembersIsNone) {
  const auto seen =
      compare_results(R"({"a": [1.5, null, {"b": "x"}], "n": 3})", R"({"n": 3, "a": [1.5, null, {"b": "x"}]})");
  ASSERT_TRUE(seen);
  EXPECT_TRUE(seen->differences.empty());
  EXPECT_EQ(seen->numbers, 2U);
}

TEST(ResultComparison, MeasuresANumberInItsOwnUncertainty) {
  EXPECT_NEAR(only(R"({"e": [{"value": 5.0, "u": 2.0}]})", R"({"e": [{"value": 5.5, "u": 2.0}]})").in_u, 0.25, 1e-12);
  EXPECT_EQ(only(R"({"e": [{"value": 5.0, "u": 2.0}]})", R"({"e": [{"value": 5.5, "u": 2.0}]})").what, "e[0].value");
  EXPECT_NEAR(only(R"({"amplitude": 1.0, "u_amplitude": 0.5})", R"({"amplitude": 2.0, "u_amplitude": 0.5})").in_u, 2.0,
              1e-12);
  EXPECT_NEAR(only(R"({"amplitude": 1.0, "u": 0.1})", R"({"amplitude": 2.0, "u": 0.1})").in_u, 10.0, 1e-12)
      << "of a deformation";
  EXPECT_NEAR(
      only(R"({"harmonics": [1.0, 2.0], "u_amplitude": 0.5})", R"({"harmonics": [1.0, 2.5], "u_amplitude": 0.5})").in_u,
      1.0, 1e-12);
  EXPECT_NEAR(only(R"({"covariance": [[4.0, 1.0], [1.0, 9.0]]})", R"({"covariance": [[4.0, 1.6], [1.0, 9.0]]})").in_u,
              0.1, 1e-12);
}

TEST(ResultComparison, AnotherBuildMayMoveANumberByAThousandthOfItsUncertainty) {
  EXPECT_TRUE(only(R"({"value": 5.0, "u": 2.0})", R"({"value": 5.0019, "u": 2.0})").tolerable);
  EXPECT_FALSE(only(R"({"value": 5.0, "u": 2.0})", R"({"value": 5.0021, "u": 2.0})").tolerable);
  EXPECT_TRUE(only(R"({"settled_s": 3000.0})", R"({"settled_s": 3000.0000009})").tolerable);
  EXPECT_FALSE(only(R"({"settled_s": 3000.0})", R"({"settled_s": 3000.000002})").tolerable);
  EXPECT_TRUE(only(R"({"sigma": 2.0})", R"({"sigma": 2.0019})").tolerable);
  EXPECT_FALSE(only(R"({"sigma": 2.0})", R"({"sigma": 2.003})").tolerable);
  EXPECT_FALSE(only(R"({"value": 5.0, "u": 2.0})", R"({"value": null, "u": 2.0})").tolerable);
  EXPECT_FALSE(only(R"({"index": 5})", R"({"index": 6})").tolerable) << "a count has no uncertainty";
  EXPECT_FALSE(only(R"({"why": "a"})", R"({"why": "b"})").tolerable);
}

// A run file of an older program lacks the members that say in fields what its texts say as well.
TEST(ResultComparison, AStoredResultWithoutTheKindsThatLaterProgramsTellLacksNothing) {
  const auto seen = compare_results(
      R"({"budget": [{"source": "mass 1"}], "warnings": ["x"]})",
      R"({"budget": [{"source": "mass 1", "kind": "mass", "mass": 1}], "warnings": ["x"], "warned": [{"kind": "hum"}]})");
  ASSERT_TRUE(seen);
  EXPECT_TRUE(seen->differences.empty());
  EXPECT_FALSE(only(R"({"warned": [{"kind": "hum"}]})", R"({"warned": [{"kind": "readings"}]})").tolerable);
  EXPECT_FALSE(only(R"({"a": 1})", R"({"a": 1, "b": 2})").tolerable);
  EXPECT_FALSE(only(R"({"phasors": [{}]})", R"({"phasors": [{"channel": "y1"}]})").tolerable) << "always told";
}

// Seen between a libm with fused multiply-add and one without: shares of 1e-33 change places.
TEST(ResultComparison, TheOrderOfNegligibleSourcesIsADifferenceThatAnotherBuildMayMake) {
  const char* stored = R"({"budget": [{"source": "a", "stiffness_share": 0.9, "damping_share": 1.0},
    {"source": "b", "stiffness_share": 2e-33, "damping_share": 0.0}, {"source": "c", "stiffness_share": 1e-33, "damping_share": 0.0}]})";
  const char* moved = R"({"budget": [{"source": "a", "stiffness_share": 0.9, "damping_share": 1.0},
    {"source": "c", "stiffness_share": 3e-33, "damping_share": 0.0}]})";
  const auto seen = compare_results(stored, moved);
  ASSERT_TRUE(seen);
  ASSERT_EQ(seen->differences.size(), 3U);
  EXPECT_EQ(seen->differences[0].what, "budget");
  EXPECT_EQ(seen->differences[1].what, "budget[b].stiffness_share");
  for (const Difference& difference : seen->differences) EXPECT_TRUE(difference.tolerable) << difference.what;
  const char* other = R"({"budget": [{"source": "b", "stiffness_share": 0.9, "damping_share": 1.0}]})";
  const auto wrong = compare_results(stored, other);
  ASSERT_TRUE(wrong);
  EXPECT_TRUE(std::any_of(wrong->differences.begin(), wrong->differences.end(),
                          [](const Difference& difference) { return !difference.tolerable; }));
}

TEST(ResultComparison, TellsZerosOfEitherSignApart) {
  EXPECT_EQ(only(R"({"value": 0.0})", R"({"value": -0.0})").replayed, "-0.0");
}

TEST(ResultComparison, NamesWhatIsMissingOrTooMuch) {
  EXPECT_EQ(only(R"({"a": 1, "b": {"c": 2}})", R"({"a": 1})").what, "b");
  EXPECT_EQ(only(R"({"a": 1})", R"({"a": 1, "b": {"c": 2}})").what, "b");
  EXPECT_EQ(only(R"({"a": [1, 2]})", R"({"a": [1, 2, 3]})").replayed, "3 entries");
  EXPECT_EQ(only(R"({"covariance": [[1.0]]})", R"({"covariance": []})").what, "covariance");
  EXPECT_EQ(only(R"({"covariance": [[1.0], 3]})", R"({"covariance": [[1.0], [3]]})").what, "covariance[1]");
}

TEST(ResultComparison, CountsNumbersInTextAsItDoesWhenItCompares) {
  const char* text = R"({"a": [1.5e-3, null, -2, {"b\\\"": "x, 3"}], "n1": 3, "t": true, "s": "4", "e": 1E+5})";
  EXPECT_EQ(numbers_in(text), 4U);
  EXPECT_EQ(compare_results(text, text)->numbers, 4U);
}

TEST(ResultComparison, RefusesWhatIsNoObject) {
  for (const char* text : {"", "[]", "{", "3", "{\"a\": 1e999}"}) EXPECT_FALSE(compare_results(text, "{}")) << text;
}

}  // namespace
}  // namespace dwell::ctl
