// The file of outcomes, and the comparison of two.
#include "tests/study/results.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace dwell::study {
namespace {

Results some() {
  Results results;
  results.seed = 7;
  for (int i = 0; i < 400; ++i) {
    Outcome outcome;
    outcome.index = i;
    outcome.settled = outcome.completed = i % 100 != 3;
    outcome.period_s = 0.25;
    outcome.left = i % 50 == 0 ? 1.5 : 0.25;
    outcome.elements.resize(2);
    outcome.elements[1].reported = true;
    outcome.elements[1].c_U95 = i % 20 == 0 ? -1.1 : 0.3;
    results.begun[Population::white].push_back(outcome);
    results.begun[Population::resonance].push_back(outcome);
    DisturbedOutcome disturbed;
    disturbed.index = i;
    disturbed.kinds = {Kind::late, Kind::clip_one};
    disturbed.worst = disturbed.worst_silent = i % 10 == 0 ? INFINITY : 2.0;
    results.disturbed.push_back(disturbed);
  }
  results.steps[Population::stop].push_back({5, true, false, 2.5, 3.0});
  results.hours.push_back({6, 0.25, 1});
  results.ramps.push_back({7, true, false});
  return results;
}

TEST(StudyResults, AreReadAsTheyWereWritten) {
  const Results results = some();
  std::stringstream file, again;
  write(file, results);
  Results back;
  ASSERT_EQ(read(file, back), "");
  EXPECT_EQ(back.seed, 7U);
  const std::vector<Row> a = rows_of(results, 0), b = rows_of(back, 0);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].reached, b[i].reached) << a[i].figure;
  write(again, back);
  EXPECT_EQ(file.str(), again.str());
}

TEST(StudyResults, AFileThatIsNoneIsRefusedWithItsLine) {
  for (const auto& [text, where] : {std::pair{"nonsense\n", "line 1"},
                                    {"dwell_study outcomes, seed 1\nwhite 3 masses x\n", "line 2"},
                                    {"dwell_study outcomes, seed 1\nnone 3\n", "line 2"},
                                    {"dwell_study outcomes, seed 1\nramps 3 found 1 beyond 0 more\n", "line 2"}}) {
    std::istringstream file(text);
    Results results;
    EXPECT_EQ(read(file, results).substr(0, 6), where) << text;
  }
}

TEST(StudyCompare, TheSameRunIsNowhereWorse) {
  const Results results = some();
  std::vector<std::string> lines;
  bool worse = true;
  EXPECT_EQ(compare(results, results, lines, worse), "");
  EXPECT_FALSE(worse);
}

TEST(StudyCompare, AFewMoreEarlyVerdictsAreNoDifferenceAndManyAre) {
  const Results before = some();
  for (const auto& [every, expected] : {std::pair{200, false}, {15, true}}) {
    Results after = before;
    for (Outcome& outcome : after.begun[Population::white])
      if (outcome.index % every == 1) outcome.left = 2.0;
    std::vector<std::string> lines;
    bool worse = false;
    EXPECT_EQ(compare(before, after, lines, worse), "");
    EXPECT_EQ(worse, expected) << every;
    worse = true;
    EXPECT_EQ(compare(after, before, lines, worse), "");
    EXPECT_FALSE(worse);
  }
}

TEST(StudyCompare, OnlyDwellsThatAreInBothCount) {
  const Results before = some();
  Results after = before;
  after.begun[Population::white].resize(100);
  after.disturbed.clear();
  std::vector<std::string> lines;
  bool worse = false;
  EXPECT_EQ(compare(before, after, lines, worse), "");
  EXPECT_FALSE(worse);
  after.seed = 8;
  EXPECT_NE(compare(before, after, lines, worse), "");
}

}  // namespace
}  // namespace dwell::study
