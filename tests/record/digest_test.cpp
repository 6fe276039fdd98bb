#include "daemon/record/digest.hpp"

#include <gtest/gtest.h>

namespace dwell::record {
namespace {

// Computed with Python's hashlib from the page on the run file.
TEST(Digest, TheFirstHeadIsAsThePageSays) {
  EXPECT_EQ(hex(next_head({}, {.seq = 1, .kind = "run", .t_ns = -5, .body = "{}"})),
            "505ca816b28a7fbdb1bede98fd06612295ede63c1803ca8e877b0bb6d21fa2ce");
}

TEST(Digest, EveryPartOfAnEntryAndTheHeadBeforeChangeTheHead) {
  const Entry entry{.seq = 7, .kind = "event", .t_ns = 12, .body = "body"};
  const Digest head = next_head({}, entry);
  Entry other = entry;
  other.seq = 8;
  EXPECT_NE(next_head({}, other), head);
  other = entry;
  other.kind = "even";
  other.body = "tbody";  // the same bytes, cut elsewhere
  EXPECT_NE(next_head({}, other), head);
  other = entry;
  other.t_ns = 13;
  EXPECT_NE(next_head({}, other), head);
  EXPECT_NE(next_head({1}, entry), head);
}

TEST(Digest, Base64IsTheStandardOneWithPadding) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace dwell::record
