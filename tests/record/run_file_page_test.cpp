// docs/run-file.md gives the codes of records as the program writes them.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "core/stream/record.hpp"

namespace dwell::record {
namespace {

std::string page() {
  std::ostringstream text;
  text << std::ifstream(DWELL_SOURCE "/docs/run-file.md").rdbuf();
  return text.str();
}

TEST(RunFilePage, EachFaultHasItsCode) {
  const std::string text = page();
  for (int code = 0; code < kFaultCount; ++code) {
    const std::string entry = std::to_string(code) + " `" + to_string(static_cast<Fault>(code)) + "`";
    EXPECT_NE(text.find(entry), std::string::npos) << entry;
  }
  EXPECT_EQ(text.find(std::to_string(kFaultCount) + " `"), std::string::npos) << "a fault that there is not";
}

TEST(RunFilePage, EachKindHasItsCode) {
  const std::string text = page();
  const std::pair<Kind, const char*> kinds[] = {{Kind::sample, "sample"},
                                                {Kind::channel_state, "channel state"},
                                                {Kind::edge, "edge of a GPIO input"},
                                                {Kind::action, "action of an operator"},
                                                {Kind::tick, "tick"},
                                                {Kind::run, "run"},
                                                {Kind::loss, "loss"},
                                                {Kind::fault, "fault"}};
  for (const auto& [kind, name] : kinds) {
    const std::string row = "\n| " + std::to_string(static_cast<int>(kind)) + " " + name;
    EXPECT_NE(text.find(row), std::string::npos) << row;
  }
}

}  // namespace
}  // namespace dwell::record
