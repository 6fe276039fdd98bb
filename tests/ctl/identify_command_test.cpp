// dwellctl identify as its users see it: exit code, what is printed, what is said on standard error.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
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

TEST(CommandLine, IdentifyAndVerifySayWhatIsNoFile) {
  const test::TemporaryFolder folder;
  const std::string pipe = folder.path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const char* verb : {"identify", "verify"}) {
    for (const std::string& path : {pipe, folder.path(""), std::string("/dev/zero")}) {
      const Outcome refused = run({verb, path});
      EXPECT_EQ(refused.code, 2) << path;
      EXPECT_EQ(refused.err, "dwellctl: " + path + ": is no regular file\n");
    }
    const std::string secret = folder.file("secret", "x");
    ASSERT_EQ(::chmod(secret.c_str(), 0), 0);
    if (::geteuid() == 0) continue;  // may read any file
    const Outcome refused = run({verb, secret});
    EXPECT_EQ(refused.code, 2);
    EXPECT_EQ(refused.err, "dwellctl: " + secret + ": Permission denied\n");
  }
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

// As recording(), but the table is at rest at first, and y0 is read so many seconds late.
std::string start_up(double late_s) {
  constexpr double omega = 2.0 * std::numbers::pi * 4.0, ramp_s = 0.3;
  const auto motion_mm = [](double t_s) {
    const double since_s = std::max(0.0, t_s - 1.0);
    return 0.5 * (1.0 - std::exp(-since_s / ramp_s)) * std::sin(omega * since_s);
  };
  std::string text = "t,y0,reaction\n";
  for (int i = 0; i < 2000; ++i) {
    const double t_s = i / 200.0, dt = 1e-5;
    const double velocity = (motion_mm(t_s + dt) - motion_mm(t_s - dt)) / (2.0 * dt);
    const double force = 1e-3 * (240000.0 * motion_mm(t_s) + 310.0 * velocity);
    const double noise = std::sin(1e4 * i * i);  // without a pattern
    std::array<char, 120> line{};
    std::snprintf(line.data(), line.size(), "%.6f,%.9g,%.9g\n", t_s, motion_mm(t_s - late_s) + 1e-4 * noise,
                  force + 0.02 * std::sin(3e4 * i * i));
    text += line.data();
  }
  return text;
}

TEST(CommandLine, IdentifyDoubtsADwellWhoseStartContradictsTheChain) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", kRig), late = folder.file("late.csv", start_up(0.02));
  const Outcome right = run({"identify", "--rig", rig, folder.file("right.csv", start_up(0.0))});
  EXPECT_EQ(right.code, 0) << right.out << right.err;
  // Of the steady motion alone a delay is damping.
  EXPECT_EQ(run({"identify", "--rig", rig, late, "--method", "harmonic"}).code, 0);
  const Outcome both = run({"identify", "--rig", rig, late});
  EXPECT_EQ(both.code, 1) << both.out;
  EXPECT_NE(both.out.find("a delay of y0 of "), std::string::npos) << both.out;
  const Json dwell = Json::parse(run({"identify", "--rig", rig, late, "--json"}).out)["dwells"][0];
  ASSERT_EQ(dwell["doubts"].size(), 1U);
  EXPECT_EQ(dwell["warnings"][0], dwell["doubts"][0]["what"]);
  EXPECT_EQ(dwell["doubts"][0]["what"].get<std::string>().find("any motion: "), 0U);
}

// As recording(), with noise; so many readings of y0 each are as old as the first of them, noise apart.
std::string steady(int refreshed_every) {
  constexpr double omega = 2.0 * std::numbers::pi * 4.0;
  std::string text = "t,y0,reaction\n";
  double read_mm = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double phase = omega * i / 200.0,
                 force = 1e-3 * 0.5 * (240000.0 * std::sin(phase) + omega * 310.0 * std::cos(phase));
    if (i % refreshed_every == 0) read_mm = 0.5 * std::sin(phase);
    std::array<char, 120> line{};
    std::snprintf(line.data(), line.size(), "%.6f,%.9g,%.9g\n", i / 200.0, read_mm + 1e-3 * std::sin(1e4 * i * i),
                  force + 0.2 * std::sin(3e4 * i * i));
    text += line.data();
  }
  return text;
}

// The numbers stand: how far they are off is not known.
TEST(CommandLine, IdentifyWarnsOfADwellWhoseTableReadingsErrInAPattern) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", kRig), old = folder.file("old.csv", steady(4));
  const Outcome right = run({"identify", "--rig", rig, folder.file("right.csv", steady(1))});
  EXPECT_EQ(right.out.find("err in a pattern"), std::string::npos) << right.out;
  const Outcome wrong = run({"identify", "--rig", rig, old});
  EXPECT_EQ(wrong.code, 0) << wrong.out << wrong.err;
  EXPECT_NE(wrong.out.find("any motion: the readings of y0 err in a pattern, by "), std::string::npos) << wrong.out;
  const Json dwell = Json::parse(run({"identify", "--rig", rig, old, "--json"}).out)["dwells"][0];
  EXPECT_TRUE(dwell["doubts"].empty()) << dwell["doubts"];
  ASSERT_FALSE(dwell["warnings"].empty());
  const std::string warning = dwell["warnings"].back();
  EXPECT_EQ(warning.find("any motion: the readings of y0 err in a pattern, by "), 0U) << warning;
  EXPECT_TRUE(warning.ends_with("The ± of this dwell does not cover it")) << warning;
}

TEST(CommandLine, IdentifySaysOnceWhatPlusMinusMeansByWhateverMethod) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", kRig), data = folder.file("data.csv", start_up(0.0));
  for (const char* method : {"harmonic", "motion", "both"}) {
    const Outcome outcome = run({"identify", "--rig", rig, data, "--method", method});
    EXPECT_EQ(outcome.code, 0) << method << outcome.out << outcome.err;
    for (const std::string line : {"± is the half width of the 95 % interval", "not stated: "}) {
      const auto at = outcome.out.find(line);
      EXPECT_NE(at, std::string::npos) << method << outcome.out;
      EXPECT_EQ(outcome.out.find(line, at + 1), std::string::npos) << method << outcome.out;
    }
  }
}

// A clipped load cell reads less force than there is. A search for what the rig file lacks would call that a scale.
TEST(CommandLine, IdentifyBlamesClippedReadingsAndLooksForNothingElse) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", kRig);
  std::string clipped;
  std::istringstream lines(start_up(0.0));
  for (std::string line; std::getline(lines, line);) {
    const auto comma = line.rfind(',');
    const double force = std::atof(line.c_str() + comma + 1);
    if (clipped.empty() || std::abs(force) < 90) {
      clipped += line + "\n";
    } else {
      clipped += line.substr(0, comma) + (force > 0 ? ",90\n" : ",-90\n");
    }
  }
  const std::string data = folder.file("clipped.csv", clipped);
  for (const char* method : {"both", "motion"}) {
    const Outcome outcome = run({"identify", "--rig", rig, data, "--method", method});
    EXPECT_EQ(outcome.code, 1) << outcome.out;
    EXPECT_NE(
        outcome.out.find("the readings themselves are at fault, so nothing that the rig file lacks is looked for: "
                         "reaction: clipped: "),
        std::string::npos)
        << method << outcome.out;
    for (const char* sought : {"missing: ", "scale of reaction", "check the rig file"})
      EXPECT_EQ(outcome.out.find(sought), std::string::npos) << method << outcome.out;
  }
}

// The dwell leaves the repeats out. The method of any motion takes them in, and to it they look like a delay.
TEST(CommandLine, RepeatedReadingsGiveAnyMotionNoReasonToDoubtTheDwell) {
  const test::TemporaryFolder folder;
  std::string repeated, t_s, last;
  std::istringstream lines(start_up(0.0));
  for (int i = 0; std::getline(lines, t_s, ','); ++i) {
    std::string y0, reaction;
    std::getline(lines, y0, ',');
    std::getline(lines, reaction);
    if (i > 1 && std::fmod(0.618034 * i * i, 1.0) < 0.05) y0 = last;
    last = y0;
    repeated += t_s + "," + y0 + "," + reaction + "\n";
  }
  const std::string data = folder.file("repeated.csv", repeated), rig = folder.file("rig.toml", kRig);
  const Outcome harmonic = run({"identify", "--rig", rig, data, "--method", "harmonic"});
  EXPECT_EQ(harmonic.code, 0) << harmonic.out << harmonic.err;
  const Outcome both = run({"identify", "--rig", rig, data});
  EXPECT_EQ(both.code, 0) << both.out << both.err;
  EXPECT_NE(
      both.out.find("the readings themselves are at fault, so nothing that the rig file lacks is looked for: y0: "),
      std::string::npos)
      << both.out;
  EXPECT_EQ(both.out.find("a delay of "), std::string::npos) << both.out;
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
