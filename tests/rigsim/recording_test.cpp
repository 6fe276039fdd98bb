#include "tests/rigsim/recording.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

namespace rigsim {
namespace {

std::vector<std::vector<std::string>> rows_of(const Options& rig, const RecordingOptions& recording) {
  std::stringstream text;
  EXPECT_EQ(write_recording(text, rig, recording), "");
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(text, line);) {
    std::vector<std::string> cells(1);
    for (const char c : line) {
      if (c == ',')
        cells.emplace_back();
      else
        cells.back() += c;
    }
    rows.push_back(cells);
  }
  return rows;
}

double model(const Options& rig, double t_s, std::size_t channel) {
  dwell::DrivenChain chain(rig.chain, rig.drive,
                           rig.from_steady ? dwell::DrivenChain::Start::steady : dwell::DrivenChain::Start::rest);
  const auto& motion = chain.at(t_s);
  return channel < motion.y.size() ? motion.y[channel] : motion.ground_force;
}

TEST(Recording, WideHoldsTheModelToTheLastDigit) {
  Options rig;
  rig.from_steady = true;
  const auto rows = rows_of(rig, {.duration_s = 0.1, .rate_hz = 100});
  ASSERT_EQ(rows.size(), 12U);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"t", "y0", "y1", "y2", "y3", "reaction"}));
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double t_s = std::stod(rows[i][0]);
    EXPECT_EQ(t_s, static_cast<double>(i - 1) / 100.0);
    for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(std::stod(rows[i][k + 1]), model(rig, t_s, k));
  }
}

TEST(Recording, LongHoldsEachSampleWithItsOwnInstant) {
  const Options rig;
  const auto rows =
      rows_of(rig, {.duration_s = 0.2, .rate_hz = 200, .skew_s = 0.005, .jitter = 0.1, .long_form = true});
  EXPECT_EQ(rows.size(), 1U + 41U * 5U);
  double before = 0.0;
  std::map<std::string, std::vector<double>> instants;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double t_s = std::stod(rows[i][0]);
    EXPECT_GE(t_s, before);
    before = t_s;
    instants[rows[i][1]].push_back(t_s);
    const std::size_t channel = rows[i][1] == "reaction" ? 4 : static_cast<std::size_t>(rows[i][1][1] - '0');
    EXPECT_EQ(std::stod(rows[i][2]), model(rig, t_s, channel));
  }
  ASSERT_EQ(instants.size(), 5U);
  for (std::size_t i = 1; i < 41; ++i) {
    EXPECT_NEAR(instants["y0"][i], 0.005 * static_cast<double>(i), 0.1 * 0.005 + 1e-12);
    EXPECT_NEAR(instants["reaction"][i], 0.005 * static_cast<double>(i) + 0.005, 0.1 * 0.005 + 1e-12);
  }
}

TEST(Recording, WideWithSkewHidesIt) {
  const Options rig;
  const auto rows = rows_of(rig, {.duration_s = 0.1, .rate_hz = 100, .skew_s = 0.02});
  ASSERT_EQ(rows.size(), 12U);
  EXPECT_EQ(std::stod(rows[5][1]), model(rig, 0.04, 0));
  EXPECT_EQ(std::stod(rows[5][5]), model(rig, 0.04 + 0.02, 4));
}

TEST(Recording, ActsOnItsScript) {
  const Options rig;
  const auto rows =
      rows_of(rig, {.duration_s = 40, .rate_hz = 50, .script = {"1 stuck y1 on", "2 stop", "3 invalid 1"}});
  EXPECT_EQ(rows[1 + 70][2], rows[1 + 60][2]);
  EXPECT_NE(rows[1 + 70][3], rows[1 + 60][3]);
  EXPECT_EQ(std::stod(rows[1 + 120][1]), 0.0);
  EXPECT_EQ(rows[1 + 200][1], "");
}

TEST(Recording, RefusesAScriptItCannotFollow) {
  const Options rig;
  std::ostringstream out;
  for (const auto& script :
       {std::vector<std::string>{"stop"}, {"2 stop", "1 start"}, {"1"}, {"0.1 nonsense 1"}, {"0.1 noise x"}})
    EXPECT_NE(write_recording(out, rig, {.duration_s = 1.0, .rate_hz = 100, .script = script}), "");
}

TEST(Recording, OfTheSameSeedIsTheSame) {
  Options rig;
  rig.faults.noise = 0.01;
  const RecordingOptions recording{.duration_s = 0.5, .rate_hz = 100, .jitter = 0.2, .long_form = true};
  const auto first = rows_of(rig, recording);
  EXPECT_EQ(rows_of(rig, recording), first);
  rig.seed = 2;
  EXPECT_NE(rows_of(rig, recording), first);
}

}  // namespace
}  // namespace rigsim
