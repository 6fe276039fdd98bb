#include "daemon/record/utf8.hpp"

#include <gtest/gtest.h>

#include "daemon/record/signature.hpp"
#include "tests/record/altered_files.hpp"

namespace dwell::record {
namespace {

TEST(Utf8, TakesEveryCharacterInItsShortestForm) {
  for (const char* text : {"", "reviewed", "gepr\u00fcft", "\u20ac", "\U0001F4CF", "\xF4\x8F\xBF\xBF"})
    EXPECT_EQ(why_not_utf8(text), "") << text;
}

TEST(Utf8, NamesTheFirstByteThatIsNone) {
  EXPECT_EQ(why_not_utf8("gepr\xfc"
                         "ft"),
            "byte 5 is 0xFC, expected text in UTF-8");
  for (const char* text :
       {"\x80", "\xC0\xAF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xF5", "\xC3", "\xE2\x82"})
    EXPECT_EQ(why_not_utf8(text).rfind("byte 1 is 0x", 0), 0u) << text;
}

TEST(Utf8, NothingElseIsSigned) {
  const Scratch scratch;
  const std::string path = scratch.path("a.dwell");
  write_sample(path, {});
  const Files before = files_in(scratch);
  PersonalSignature words;
  words.name = "Anna";
  words.meaning =
      "gepr\xfc"
      "ft";
  words.utc = "2026-01-01T00:00:00Z";
  const auto own = sign_by_own_key(path, words, sample_other());
  ASSERT_FALSE(own);
  EXPECT_EQ(own.error(), "meaning: byte 5 is 0xFC, expected text in UTF-8");
  words.person = Person{1000, "anna"};
  EXPECT_FALSE(sign_by_service(path, words, sample_key()));
  EXPECT_EQ(files_in(scratch), before);
}

}  // namespace
}  // namespace dwell::record
