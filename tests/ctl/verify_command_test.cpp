// `dwellctl verify` and `dwellctl export --model` on recordings of a simulated start-up.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>

#include "core/model/driven_chain.hpp"
#include "daemon/ctl/commands.hpp"
#include "tests/api_schema.hpp"
#include "tests/ctl/temporary.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell::ctl {
namespace {

using Value = nlohmann::json;

const Chain& bench_chain() {
  static const Chain chain{Boundary::clamped, {12.5}, {24000.0, 9000.0}, {60.0, 30.0}};
  return chain;
}

std::string rig_text(double mass, const std::string& more = "") {
  return "[rig]\nname = \"bench\"\nboundary = \"clamped\"\nmasses = [" + std::to_string(mass) +
         "]\nmass_u = [0.01]\n[excitation]\nfrequency = 6.0\nminimum = 2e-5\n" + more +
         "[[channel]]\nname = \"y0\"\nmeasures = \"displacement\"\nat = 0\nunit = \"m\"\nscale_u = 0.0005\n"
         "[[channel]]\nname = \"y1\"\nmeasures = \"displacement\"\nat = 1\nunit = \"m\"\nscale_u = 0.0005\n"
         "[[channel]]\nname = \"reaction\"\nmeasures = \"force\"\nat = \"ground\"\nunit = \"N\"\nscale_u = 0.0005\n";
}

// then_hz: the drive's frequency in the second half, if given.
std::string start_up(DrivenChain::Start start, double then_hz = 0.0) {
  DrivenChain motion(bench_chain(), {.frequency_hz = 6.0, .amplitude = 5e-3, .ramp_s = 0.2}, start);
  std::mt19937_64 rng(3);
  std::normal_distribution<double> noise(0.0, 1e-3);
  std::string text = "t,y0,y1,reaction\n";
  for (int i = 0; i < 8000; ++i) {
    const double t_s = i / 400.0;
    if (i == 4000 && then_hz > 0) motion.set_drive(t_s, {.frequency_hz = then_hz, .amplitude = 5e-3, .ramp_s = 0.2});
    const ChainMotion& now = motion.at(t_s);
    char line[120];
    std::snprintf(line, sizeof line, "%.4f,%.9g,%.9g,%.9g\n", t_s, now.y[0] + 5e-3 * noise(rng),
                  now.y[1] + 5e-3 * noise(rng), now.ground_force + 50 * noise(rng));
    text += line;
  }
  return text;
}

struct Printed {
  int code;
  std::string text;
};
Printed verify(const std::string& rig, const std::string& data, bool json, std::optional<int> dwell = {}) {
  testing::internal::CaptureStdout();
  const int code = verify_recording({rig, data, dwell, json});
  return {code, testing::internal::GetCapturedStdout()};
}

TEST(VerifyCommand, FindsARightModelAdequate) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", rig_text(12.5));
  const std::string data = folder.file("start.csv", start_up(DrivenChain::Start::rest));
  const Printed json = verify(rig, data, true);
  EXPECT_EQ(json.code, kDone) << json.text;
  const Value seen = Value::parse(json.text);
  EXPECT_EQ(seen["verdict"], "adequate");
  EXPECT_EQ(seen["consistent"], true);
  EXPECT_EQ(seen["accuracy"]["asked"], 0.05);
  EXPECT_EQ(test::ApiSchema().faults("verification", seen), "");
  const Printed table = verify(rig, data, false);
  EXPECT_EQ(table.code, kDone);
  EXPECT_NE(table.text.find("verdict     adequate for predictions within 5 %"), std::string::npos) << table.text;
}

TEST(VerifyCommand, HoldsToTheAccuracyOfTheRigFile) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", rig_text(12.5, "[verification]\naccuracy = 1e-4\n"));
  const Printed json = verify(rig, folder.file("start.csv", start_up(DrivenChain::Start::rest)), true);
  EXPECT_EQ(json.code, kNo);
  EXPECT_EQ(Value::parse(json.text)["verdict"], "not verified yet");
}

TEST(VerifyCommand, CallsNothingAdequateOfAWrongMass) {
  if (kUnderSanitizer) GTEST_SKIP() << "minutes of a search of core's, whose tests go through it";
  const test::TemporaryFolder folder;
  const std::string data = folder.file("start.csv", start_up(DrivenChain::Start::rest));
  const Printed wrong = verify(folder.file("rig.toml", rig_text(18.0)), data, true);
  EXPECT_EQ(wrong.code, kNo);
  EXPECT_NE(Value::parse(wrong.text)["verdict"], "adequate");
  EXPECT_EQ(Value::parse(wrong.text)["consistent"], false);
  const Value missing = Value::parse(wrong.text)["missing"];
  EXPECT_TRUE(std::any_of(missing.begin(), missing.end(), [](const Value& one) { return one["what"] == "mass 1"; }))
      << wrong.text;
  EXPECT_EQ(test::ApiSchema().faults("verification", Value::parse(wrong.text)), "");
  const Printed told = verify(folder.file("rig.toml", rig_text(18.0)), data, false);
  EXPECT_NE(told.text.find("missing     "), std::string::npos) << told.text;
}

TEST(VerifyCommand, CallsNothingAdequateWithoutEvidence) {
  const test::TemporaryFolder folder;
  const Printed steady =
      verify(folder.file("rig.toml", rig_text(12.5)), folder.file("s.csv", start_up(DrivenChain::Start::steady)), true);
  EXPECT_EQ(steady.code, kNo);
  EXPECT_EQ(Value::parse(steady.text)["verdict"], "not verified yet");
  EXPECT_FALSE(Value::parse(steady.text)["reasons"].empty());
}

TEST(VerifyCommand, HoldsTheDwellsOfARecordingAgainstEachOther) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", rig_text(12.5, "search = [4.5, 12.0]\n"));
  const std::string data = folder.file("two.csv", start_up(DrivenChain::Start::rest, 7.5));
  for (const int dwell : {0, 1}) {
    const Printed json = verify(rig, data, true, dwell == 0 ? std::nullopt : std::optional<int>(dwell));
    EXPECT_EQ(json.code, kDone) << json.text;
    const Value seen = Value::parse(json.text);
    EXPECT_EQ(seen["evidence"].size(), 2U) << json.text;
    for (const Value& channel : seen["channels"]) EXPECT_GT(channel["frac"].get<double>(), 0.9999);
    EXPECT_EQ(test::ApiSchema().faults("verification", seen), "");
  }
  const Printed told = verify(rig, data, false);
  EXPECT_NE(told.text.find("evidence    dwell 1 at 6 Hz from "), std::string::npos) << told.text;
  EXPECT_NE(told.text.find("FRAC"), std::string::npos) << told.text;
}

TEST(VerifyCommand, RefusesWhatCannotBeRead) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", rig_text(12.5));
  EXPECT_EQ(verify(rig, folder.path("none.csv"), false).code, kUsage);
  EXPECT_EQ(verify(folder.path("none.toml"), rig, false).code, kUsage);
  EXPECT_EQ(verify(rig, folder.file("start.csv", start_up(DrivenChain::Start::rest)), false, 7).code, kUsage);
}

std::string contents_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

TEST(ExportCommand, WritesTheModelWithItsVerdict) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", rig_text(12.5));
  const std::string out = folder.path("model");
  ASSERT_EQ(export_model({rig, folder.file("start.csv", start_up(DrivenChain::Start::rest)), out, {}}), kDone);
  EXPECT_EQ(contents_of(out + "/mass.mtx"),
            "%%MatrixMarket matrix coordinate real symmetric\n% unit: kg\n1 1 1\n1 1 12.5\n");
  const Value model = Value::parse(contents_of(out + "/model.json"));
  EXPECT_EQ(model["verification"]["verdict"], "adequate");
  EXPECT_NEAR(model["state_space"]["A"][1][0].get<double>(), -(24000.0 + 9000.0) / 12.5, 20.0);
  EXPECT_NEAR(model["state_space"]["C"][1][0].get<double>(), 9000.0, 50.0);
  EXPECT_EQ(model["state_space"]["outputs"][1]["unit"], "N");
  std::istringstream stiffness(contents_of(out + "/stiffness.mtx"));
  std::string line;
  for (int i = 0; i < 4; ++i) std::getline(stiffness, line);
  EXPECT_NEAR(std::stod(line.substr(4)), 33000.0, 150.0);
}

}  // namespace
}  // namespace dwell::ctl
