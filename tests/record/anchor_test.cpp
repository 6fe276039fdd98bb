#include "daemon/record/anchor.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

const std::string kAnchorLine =
    "2026-11-23T03:12:17.250000Z dwell/run/0123456789abcdef0123456789abcdef 42 "
    "BwAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=";

TEST(Anchor, ALineIsReadAsItWasWrittenAlsoFromAJournal) {
  const Scratch scratch;
  const std::string path = scratch.write("anchors", "# of rig 7\n\n" + kAnchorLine +
                                                        "\nNov 23 04:12:17 rig dwelld[12]: anchor: " + kAnchorLine +
                                                        "\nNov 23 04:12:18 rig dwelld[12]: the rig is up\n");
  const auto anchors = read_anchors(path);
  ASSERT_TRUE(anchors) << anchors.error();
  ASSERT_EQ(anchors->size(), 2u);
  for (const Anchor& anchor : *anchors) {
    EXPECT_EQ(anchor.seq, 42);
    EXPECT_EQ(anchor.head, Digest{7});
    EXPECT_EQ(to_line(anchor), kAnchorLine);
  }
}

TEST(Anchor, ALineThatIsNoneIsNamed) {
  const Scratch scratch;
  for (const std::string& wrong : {kAnchorLine + " more", kAnchorLine.substr(0, kAnchorLine.size() - 1),
                                   kAnchorLine.substr(20), kAnchorLine.substr(0, 75)}) {
    const auto anchors = read_anchors(scratch.write("anchors", (kAnchorLine + "\n").append(wrong)));
    ASSERT_FALSE(anchors) << wrong;
    EXPECT_NE(anchors.error().find("line 2"), std::string::npos) << anchors.error();
  }
  EXPECT_FALSE(read_anchors(scratch.write("none", "nothing of the kind\n")));
  EXPECT_FALSE(read_anchors(scratch.path("missing")));
  EXPECT_FALSE(read_anchors(scratch.path()));
}

}  // namespace
}  // namespace dwell::record
