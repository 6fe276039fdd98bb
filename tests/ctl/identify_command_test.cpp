// dwellctl identify as its users see it: exit code, what is printed, what is said on standard error.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/ctl/program.hpp"
#include "tests/ctl/small_rig.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell {
namespace {

using Json = nlohmann::ordered_json;
using test::kRig;
using test::Outcome;
using test::recording;
using test::run;

TEST(CommandLine, IdentifyPrintsTheDwellsOfARecording) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", kRig);
  const std::string data = folder.file("other.csv", recording(0.5, "t,y0,reaction"));
  const Outcome table = run({"identify", "--rig", rig, data});
  EXPECT_EQ(table.code, 0) << table.err;
  EXPECT_NE(table.out.find("240.0"), std::string::npos) << table.out;
  const Outcome json = run({"identify", "--rig", rig, data, "--json"});
  EXPECT_EQ(json.code, 0) << json.err;
  const Json document = Json::parse(json.out);
  EXPECT_EQ(document["rig"], "mount");
  ASSERT_EQ(document["dwells"].size(), 1U);
  EXPECT_NEAR(document["dwells"][0]["elements"][0]["stiffness"]["value"].get<double>(), 240000.0, 0.24);
  EXPECT_EQ(document["dwells"][0]["rig_sha256"].get<std::string>().size(), 64U);
}

TEST(CommandLine, IdentifySaysWhyThereIsNothing) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", kRig);
  const Outcome still =
      run({"identify", "--rig", rig, folder.file("still.csv", recording(1e-3, "t,y0,reaction")), "--json"});
  EXPECT_EQ(still.code, 1);
  EXPECT_NE(still.err.find("excitation.minimum"), std::string::npos) << still.err;
  EXPECT_TRUE(Json::parse(still.out)["dwells"].empty());
  const Outcome missing = run({"identify", "--rig", rig, folder.file("m.csv", recording(0.5, "t,y0,torque"))});
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.err.find("no column for reaction; there are y0, torque"), std::string::npos) << missing.err;
  const Outcome unreadable = run({"identify", "--rig", rig, folder.file("u.csv", "t,y0\n1,x\n")});
  EXPECT_EQ(unreadable.code, 2);
  EXPECT_NE(unreadable.err.find("u.csv:2:3: "), std::string::npos) << unreadable.err;
  EXPECT_EQ(run({"identify", "--rig", folder.path("none.toml"), folder.path("u.csv")}).code, 2);
  std::string synced = kRig;
  synced.replace(synced.find("[excitation]\n"), 13, "[excitation]\nreference = \"sync\"\n");
  synced += "\n[gpio]\nsync = { chip = \"/dev/gpiochip0\", line = 1 }\n";
  const Outcome pulses = run({"identify", "--rig", folder.file("s.toml", synced), folder.path("still.csv")});
  EXPECT_EQ(pulses.code, 2);
  EXPECT_NE(pulses.err.find("holds no pulses"), std::string::npos) << pulses.err;
}

TEST(CommandLine, IdentifySaysNoToACoefficientThatNoChainCanHave) {
  const test::TemporaryFolder folder;
  const std::string reversed = std::string(kRig) + "positive = \"mass\"\n";
  const std::string data = folder.file("data.csv", recording(0.5, "t,y0,reaction"));
  const std::string rig = folder.file("rig.toml", reversed);
  const Outcome table = run({"identify", "--rig", rig, data});
  EXPECT_EQ(table.code, 1) << table.out;
  EXPECT_NE(table.out.find("stiffness of element 1 comes out as -240000"), std::string::npos) << table.out;
  const Json dwell = Json::parse(run({"identify", "--rig", rig, data, "--json"}).out)["dwells"][0];
  EXPECT_FALSE(dwell["elements"][0]["identifiable"].get<bool>());
  EXPECT_TRUE(dwell["elements"][0]["stiffness"].is_null());
  EXPECT_NE(dwell["elements"][0]["reason"].get<std::string>().find(" ± "), std::string::npos);
  EXPECT_EQ(dwell["doubts"][0]["elements"], Json({1}));
}

TEST(CommandLine, IdentifyIgnoresAnUnknownColumnWithAWarning) {
  const test::TemporaryFolder folder;
  const std::string data = folder.file("d.csv", recording(0.5, "t,y0,reaction"));
  std::string text = test::contents(data);
  std::size_t line = 0;
  std::string wider;
  std::istringstream lines(text);
  for (std::string one; std::getline(lines, one); ++line) wider += one + (line == 0 ? ",spare" : ",1") + "\n";
  const Outcome outcome = run({"identify", "--rig", folder.file("rig.toml", kRig), folder.file("w.csv", wider)});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("warning: "), std::string::npos);
  EXPECT_NE(outcome.err.find("spare"), std::string::npos);
}

}  // namespace
}  // namespace dwell
