#include "daemon/ctl/terminal.hpp"

#include <gtest/gtest.h>

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

TEST(Terminal, OldNumbersAreGreyAndWithoutColoursFaint) {
  const std::vector<TextLine> lines{{"± 1", Style::plain}, {"24 kN/m", Style::old}, {"no", Style::alarm}};
  EXPECT_EQ(frame(lines, true), "\x1b[H± 1\x1b[K\r\n\x1b[90m24 kN/m\x1b[0m\x1b[K\r\n\x1b[1;31mno\x1b[0m\x1b[K\x1b[J");
  EXPECT_EQ(frame(lines, false), "\x1b[H± 1\x1b[K\r\n\x1b[2m24 kN/m\x1b[0m\x1b[K\r\n\x1b[1;7mno\x1b[0m\x1b[K\x1b[J");
}

}  // namespace
}  // namespace dwell::ctl
