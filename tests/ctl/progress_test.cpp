#include "daemon/ctl/progress.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace dwell::ctl {
namespace {

// Columns on a terminal: the bytes that begin a character of UTF-8.
int columns_of(const std::string& line) {
  int columns = 0;
  for (const char c : line) columns += (static_cast<unsigned char>(c) & 0xc0U) != 0x80U ? 1 : 0;
  return columns;
}

TEST(Progress, SaysHowMuchIsDoneAndHowLongItWillTake) {
  EXPECT_EQ(progress_line("replaying", 0.5, 3.0, 46), "replaying  █████████··········  50 %  3 s left");
  EXPECT_EQ(progress_line("replaying", 0.25, 100.0, 46), "replaying  ████·············  25 %  5 min left");
  EXPECT_EQ(progress_line("replaying", 1.0, 3.0, 46), "replaying  ███████████████████ 100 %  0 s left");
}

TEST(Progress, TellsNoTimeBeforeItCanBeKnown) {
  EXPECT_EQ(progress_line("reading", 0.01, 3.0, 30).find("left"), std::string::npos);
}

TEST(Progress, FitsIntoEveryTerminal) {
  for (int width = 5; width < 200; ++width)
    for (const double part : {0.0, 0.3, 1.0, -1.0, 7.0, std::numeric_limits<double>::quiet_NaN()})
      EXPECT_LE(columns_of(progress_line("replaying", part, 1234.0, width)), width) << width << " " << part;
}

}  // namespace
}  // namespace dwell::ctl
