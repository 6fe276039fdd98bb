#include "daemon/ctl/terminal.hpp"

#include <gtest/gtest.h>

#include <regex>

#include "tests/ctl/watched.hpp"

namespace dwell::ctl {
namespace {

using Keys = std::vector<Key>;

TEST(Terminal, KeysAreLettersArrowsAndPageKeys) {
  EXPECT_EQ(keys_in(" pnbrqyx"),
            (Keys{Key::pause, Key::pause, Key::next, Key::back, Key::rearm, Key::quit, Key::yes, Key::other}));
  EXPECT_EQ(keys_in("\x1b[C\x1b[D\x1bOB\x1bOA\x1b[6~\x1b[5~"),
            (Keys{Key::next, Key::back, Key::next, Key::back, Key::next, Key::back}));
}

// The end of a sequence that is not known must not rearm the rig or end the command.
TEST(Terminal, ASequenceThatIsNotKnownIsNoKey) {
  EXPECT_EQ(keys_in("\x1b[1;5r"), Keys{});
  EXPECT_EQ(keys_in("\x1bOq\x1b[15~"), Keys{});
  EXPECT_EQ(keys_in("\x1b"), Keys{});
  EXPECT_EQ(keys_in("\x1b[23~q"), Keys{Key::quit});
}

TEST(Terminal, OldNumbersAreStruckAndGreyWithoutColoursFaint) {
  const std::vector<TextLine> lines{{"± 1", Style::plain}, {"24 kN/m", Style::old}, {"no", Style::alarm}};
  EXPECT_EQ(frame(lines, true), "\x1b[H± 1\x1b[K\r\n\x1b[90;9m24 kN/m\x1b[0m\x1b[K\r\n\x1b[1;31mno\x1b[0m\x1b[K\x1b[J");
  EXPECT_EQ(frame(lines, false), "\x1b[H± 1\x1b[K\r\n\x1b[2;9m24 kN/m\x1b[0m\x1b[K\r\n\x1b[1;7mno\x1b[0m\x1b[K\x1b[J");
}

// Select Graphic Rendition (ECMA-48, 8.3.117): 30 … 38 and 90 … 97 set a colour.
bool has_colour(const std::string& bytes) {
  return std::regex_search(bytes, std::regex("\x1b\\[([0-9;]*;)?(3[0-8]|4[0-8]|9[0-7]|10[0-7])[;m]"));
}

TEST(Terminal, WhatIsNormalHasNoColour) {
  EXPECT_TRUE(has_colour(frame({{"24 kN/m", Style::old}}, true)));
  EXPECT_TRUE(has_colour(frame({{"no", Style::alarm}}, true)));
  // A result holds: it is grey, and nothing strikes it.
  EXPECT_NE(frame({{"24 kN/m", Style::past}}, true).find("\x1b[90m24"), std::string::npos);
  EXPECT_NE(frame({{"24 kN/m", Style::past}}, false).find("\x1b[2m24"), std::string::npos);
  for (const DwellView& view : {test::chain(3), test::settling_view()}) {
    const Page page = test::at(test::watched(view), {}, {40, 120});
    EXPECT_FALSE(has_colour(frame(page.lines, true))) << test::text_of(page);
  }
}

}  // namespace
}  // namespace dwell::ctl
