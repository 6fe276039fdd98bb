#include "daemon/record/anchor.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

const std::string kAnchorLine =
    "2026-11-23T03:12:17.250000Z dwell/run/0123456789abcdef0123456789abcdef 42 "
    "BwAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=";

Result<Anchors> read_lines(const std::string& lines) {
  const Scratch scratch;
  return read_anchors(scratch.write("anchors", lines));
}

TEST(Anchor, ALineIsReadAsItWasWrittenAlsoFromALogAndAJournal) {
  for (const char* front : {
           "",
           "anchor: ",
           "2026-11-23T04:12:17.250+01:00 info anchor: ",
           "Nov 23 04:12:17 rig dwelld[12]: anchor: ",
           "Nov 23 04:12:17.250001 rig dwelld[12]: anchor: ",
           "2026-11-23T04:12:17+01:00 rig dwelld[12]: anchor: ",
           "2026-11-23T04:12:17+0100 rig dwelld[12]: anchor: ",
           "Mon 2026-11-23 04:12:17 CET rig dwelld[12]: anchor: ",
           "Mon 2026-11-23 04:12:17 CET rig dwelld@bench.service[12]: anchor: ",
       }) {
    const auto anchors =
        read_lines("# of rig 7\n\n" + (front + kAnchorLine) + "\nNov 23 04:12:18 rig dwelld[12]: the rig is up\n");
    ASSERT_TRUE(anchors) << front << anchors.error();
    ASSERT_EQ(anchors->all.size(), 1u) << front;
    EXPECT_EQ(anchors->all[0].seq, 42);
    EXPECT_EQ(anchors->all[0].head, Digest{7});
    EXPECT_EQ(to_line(anchors->all[0]), kAnchorLine);
    EXPECT_EQ(anchors->skipped, 0u);
  }
}

// The log's messages that end in words of people, as the log and the journal show them.
TEST(Anchor, WordsOfPeopleInTheLogAreNone) {
  for (const char* front :
       {"", "2026-11-23T04:12:17.250+01:00 info ", "Nov 23 04:12:17 rig dwelld[12]: ",
        "2026-11-23T04:12:17+0100 rig dwelld[12]: ", "Mon 2026-11-23 04:12:17 CET rig dwelld[12]: "})
    for (const char* message : {"run stopped by anna (uid 1000): ", "run 17 signed by ", "run \"a",
                                "alarm channel:y1 acknowledged by anna (uid 1000): ", "recording run 17 \""})
      for (const char* words : {"", "anchor: ", "info anchor: ", "dwelld[12]: anchor: ", "rig dwelld[12]: anchor: ",
                                "Nov 23 04:12:17 rig dwelld[12]: anchor: ", "04:12:17 rig dwelld[12]: anchor: ",
                                "2026-11-23T04:12:17.250+01:00 info anchor: "}) {
        const std::string line = std::string(front) + message + words + kAnchorLine;
        const auto anchors = read_lines(kAnchorLine + "\n" + line + "\n");
        ASSERT_TRUE(anchors) << line << anchors.error();
        EXPECT_EQ(anchors->all.size(), 1u) << line;
        EXPECT_EQ(anchors->skipped, 1u) << line;
      }
}

TEST(Anchor, ALineThatIsNoneIsCountedAndTakesNoOtherAway) {
  for (const std::string& wrong :
       {kAnchorLine + " more", kAnchorLine.substr(0, kAnchorLine.size() - 1), " " + kAnchorLine.substr(28),
        kAnchorLine.substr(0, 75), std::string("2026-11-23T04:12:17.250+01:00 info run \"see dwell/run/abc\" started"),
        "Nov 23 04:12:17 rig other[12]: anchor: " + kAnchorLine}) {
    const auto anchors = read_lines(kAnchorLine + "\n" + wrong);
    ASSERT_TRUE(anchors) << wrong << anchors.error();
    EXPECT_EQ(anchors->all.size(), 1u) << wrong;
    EXPECT_EQ(anchors->skipped, 1u) << wrong;
  }
}

TEST(Anchor, LongLinesAndZerosBesideItArePassedOver) {
  const Scratch scratch;
  const std::string anchor = "2026-11-23T00:00:00Z dwell/run/0 7 " + std::string(43, 'A') + "=\n";
  const std::string path = scratch.write("long", std::string(10'000'000, 'x') + "\n" + anchor);
  std::filesystem::resize_file(path, 100'000'000);
  const auto found = read_anchors(path);
  ASSERT_TRUE(found) << found.error();
  EXPECT_EQ(found->all.size(), 1U);
}

TEST(Anchor, AFileWithoutAnyIsRefused) {
  const Scratch scratch;
  EXPECT_FALSE(read_anchors(scratch.write("none", "nothing of the kind\n")));
  EXPECT_FALSE(read_anchors(scratch.path("missing")));
  EXPECT_FALSE(read_anchors(scratch.path()));
}

}  // namespace
}  // namespace dwell::record
