// [[limit]]: what is read, and mistakes in it. "@" marks where each is expected to be reported.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

// The good rig (three elements) with this behind it.
void expect_wrong(const std::string& limits, const std::string& message) {
  expect_mistake("[settling]\n", limits + "\n[settling]\n", message);
}

TEST(RigFileLimits, AreReadInTheUnitsOfTheChain) {
  const auto file = parse(std::string(kGoodRig) +
                              "[[limit]]\nelement = 3\nstiffness = [7.5e3, 8.5e3]\n[[limit]]\n"
                              "element = 1\nstiffness = [-1, 2]\ndamping = [40, 50.5]\n",
                          "rig.toml", fake_schemas());
  ASSERT_TRUE(file) << to_string("rig.toml", file.error());
  const std::vector<Limit>& limits = file->rig.limits;
  ASSERT_EQ(limits.size(), 2u);
  EXPECT_EQ(limits[0].element, 3);
  EXPECT_EQ(limits[0].stiffness->low, 7500.0);
  EXPECT_EQ(limits[0].stiffness->high, 8500.0);
  EXPECT_FALSE(limits[0].damping);
  EXPECT_EQ(limits[1].damping->high, 50.5);
}

TEST(RigFileLimits, NameAnElementOfTheChain) {
  const std::string expected = ": expected the number of an element, 1 to 3";
  expect_wrong("@[[limit]]\nstiffness = [1, 2]", "[[limit]] has no \"element\"" + expected);
  expect_wrong("[[limit]]\nelement = @0\nstiffness = [1, 2]", "\"element\" is 0" + expected);
  expect_wrong("[[limit]]\nelement = @4\nstiffness = [1, 2]", "\"element\" is 4" + expected);
  expect_wrong("[[limit]]\nelement = @\"2\"\nstiffness = [1, 2]", "\"element\" is a string" + expected);
}

TEST(RigFileLimits, StandOnceForEachElement) {
  expect_wrong("[[limit]]\nelement = 2\nstiffness = [1, 2]\n[[limit]]\nelement = @2\ndamping = [1, 2]",
               "element 2 has limits already: expected one [[limit]] for each element, with \"stiffness\" and "
               "\"damping\" in it");
}

TEST(RigFileLimits, AreTwoNumbersTheLowerFirst) {
  const std::string expected = ": expected [low, high] in N/m (N*m/rad for rotation), low < high";
  const std::string of_damping = ": expected [low, high] in N*s/m (N*m*s/rad for rotation), low < high";
  expect_wrong("[[limit]]\nelement = 1\nstiffness = @[8500, 7500]", "\"stiffness\" is [8500, 7500]" + expected);
  expect_wrong("[[limit]]\nelement = 1\nstiffness = @[1, 1]", "\"stiffness\" is [1, 1]" + expected);
  expect_wrong("[[limit]]\nelement = 1\nstiffness = @[1]", "\"stiffness\" is not two numbers" + expected);
  expect_wrong("[[limit]]\nelement = 1\nstiffness = @[1, \"2\"]", "\"stiffness\" is not two numbers" + expected);
  expect_wrong("[[limit]]\nelement = 1\ndamping = @3", "\"damping\" is an integer" + of_damping);
}

TEST(RigFileLimits, MayBeOpenOnOneSide) {
  const auto file =
      parse(std::string(kGoodRig) + "[[limit]]\nelement = 1\nstiffness = [7500, inf]\ndamping = [-inf, 50]\n",
            "rig.toml", fake_schemas());
  ASSERT_TRUE(file) << to_string("rig.toml", file.error());
  const Limit& limit = file->rig.limits.at(0);
  EXPECT_EQ(limit.stiffness->low, 7500.0);
  EXPECT_EQ(limit.stiffness->high, INFINITY);
  EXPECT_EQ(limit.damping->low, -INFINITY);
  EXPECT_EQ(limit.damping->high, 50.0);
}

TEST(RigFileLimits, HoldANumberAndReachAboveZero) {
  const std::string form = "[low, high] in N/m (N*m/rad for rotation), low < high";
  const std::string of_damping = "[low, high] in N*s/m (N*m*s/rad for rotation), low < high";
  const auto wrong = [](const std::string& limit, const std::string& message) {
    expect_wrong("[[limit]]\nelement = 1\n" + limit, message);
  };
  wrong("stiffness = @[-inf, inf]", "\"stiffness\" is [-inf, inf]: expected a number on one side at least, " + form);
  wrong("stiffness = @[inf, 7500]", "\"stiffness\" is [inf, 7500]: expected " + form);
  wrong("damping = @[nan, 50]", "\"damping\" is [nan, 50]: expected " + of_damping);
  wrong("damping = @[-inf, 0]", "\"damping\" is [-inf, 0], nowhere above 0: expected " + of_damping + ", high above 0");
  wrong("stiffness = @[-9e3, -7e3]",
        "\"stiffness\" is [-9000, -7000], nowhere above 0: expected " + form + ", high above 0");
  wrong("damping = @[-1, 0]", "\"damping\" is [-1, 0], nowhere above 0: expected " + of_damping + ", high above 0");
}

TEST(RigFileLimits, SayWhatIsLimited) {
  expect_wrong("@[[limit]]\nelement = 1",
               "[[limit]] has no \"stiffness\": expected \"stiffness\" or \"damping\" = [low, high]");
  expect_wrong("[[limit]]\nelement = 1\nstiffness = [1, 2]\n@stifness = [1, 2]",
               "unknown key \"stifness\" in [[limit]]: expected element, stiffness, damping");
}

}  // namespace
}  // namespace dwell::config::testing
