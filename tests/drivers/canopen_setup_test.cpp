// The canopen plugin's settings of the device: what contradicts itself is refused, in words.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "drivers/canopen/setup.hpp"
#include "tests/drivers/given.hpp"

namespace dwell::canopen {
namespace {

using Lines = std::vector<std::string>;

Lines mistakes_of(const std::vector<std::pair<std::string, double>>& settings) {
  test::Given given("device");
  given.set("interface", "can0");
  for (const auto& [key, value] : settings) given.set(key, value);
  given.channel("y0").set("node", 1).set("index", 0x6004);
  std::vector<Mistake> mistakes;
  static_cast<void>(read_setup(driver::Settings(*given.settings()), mistakes));
  Lines lines;
  for (const Mistake& each : mistakes) lines.push_back(std::string(each.key) + ": " + each.text);
  return lines;
}

TEST(CanopenSetup, HasDefaultsThatAgree) { EXPECT_EQ(mistakes_of({}), Lines{}); }

TEST(CanopenSetup, RefusesATimeoutThatOneLostAnswerWouldUse) {
  const std::string mistake =
      "timeout: is no longer than one answer that is lost may leave its channel without a sample; expected more than ";
  const Lines of_late{mistake + "2.53 s, or a shorter `late`"};
  EXPECT_EQ(mistakes_of({{"late", 0.5}, {"timeout", 0.3}}), of_late);
  EXPECT_EQ(mistakes_of({{"late", 0.5}, {"timeout", 2.53}}), of_late);
  EXPECT_EQ(mistakes_of({{"late", 0.5}, {"timeout", 2.54}}), Lines{});
  EXPECT_EQ(mistakes_of({{"rate", 1.0}, {"late", 0.5}, {"timeout", 2.0}}), Lines{mistake + "8 s, or a higher `rate`"});
}

TEST(CanopenSetup, RefusesAHeartbeatThatCannotBeWatched) {
  const Lines mistake{"heartbeat: is too short to be watched; expected 0, or at least 0.01 s"};
  EXPECT_EQ(mistakes_of({{"heartbeat", 0.0001}}), mistake);  // 0 ms, which would mean: as it is set
  EXPECT_EQ(mistakes_of({{"heartbeat", 0.0099}}), mistake);
  EXPECT_EQ(mistakes_of({{"heartbeat", 0.01}}), Lines{});
  EXPECT_EQ(mistakes_of({{"heartbeat", 0.0}}), Lines{});
}

}  // namespace
}  // namespace dwell::canopen
