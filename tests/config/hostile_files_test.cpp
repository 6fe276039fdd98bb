// Whatever the bytes: an answer, in bounded time and memory.
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "config/nesting.hpp"
#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

// True if the text is a rig, or has at least one mistake, each with a position and one line of text.
bool answered(std::string_view text, const SchemaSource& schemas) {
  const Result<RigFile> file = parse(text, "rig.toml", schemas);
  if (file) return true;
  bool positioned = !file.error().empty() && file.error().size() <= MistakeList::kMost + 1;
  for (const Mistake& mistake : file.error()) {
    positioned = positioned && mistake.line >= 1 && mistake.column >= 1 && !mistake.message.empty() &&
                 mistake.message.find('\n') == std::string::npos;
  }
  return positioned;
}

std::string sample(const char* name) {
  std::ostringstream text;
  text << std::ifstream(std::string(DWELL_SAMPLE_RIGS "/") + name).rdbuf();
  return text.str();
}

TEST(HostileFiles, OfMutatedSamplesAreAnswered) {
  std::mt19937 random(20160404);
  const auto below = [&](std::size_t bound) { return static_cast<std::size_t>(random() % bound); };
  const std::string_view pieces[] = {
      "[",          "]",        "{",   "}",    "\"", "'''",  "=",         "\n",         ".",
      "-1",         "nan",      "0",   "#",    ",",  "1e",   "inf",       "[[",         "\"\"\"",
      "\xff",       "\xc3\xa9", "\\u", "true", "at", "unit", "[channel]", "2027-03-31", "9223372036854775808",
      "99999999999"};
  for (const char* name : {"clamped.toml", "suspension.toml", "shaft.toml", "replay.toml"}) {
    const std::string original = sample(name);
    ASSERT_FALSE(original.empty()) << name;
    for (int round = 0; round < 400; ++round) {
      std::string text = original;
      for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
        const std::size_t at = below(text.size());
        switch (below(5)) {
          case 0:
            text[at] = static_cast<char>(below(256));
            break;
          case 1:
            text.erase(at, 1 + below(20));
            break;
          case 2:
            text.insert(at, pieces[below(std::size(pieces))]);
            break;
          case 3:
            text.replace(at, 1 + below(8), pieces[below(std::size(pieces))]);
            break;
          default:
            text.insert(at, text.substr(below(text.size()), below(60)));
            break;
        }
        if (text.empty()) break;
      }
      ASSERT_TRUE(answered(text, fake_schemas())) << name << " in round " << round << ":\n" << text;
      ASSERT_TRUE(answered(text, nullptr)) << name << " in round " << round << ":\n" << text;
    }
  }
}

TEST(HostileFiles, OfRandomBytesAreAnswered) {
  std::mt19937 random(7);
  const std::string_view alphabet = "[]{}=\"'.,#\n\r\t \\-_abru019:TZ\xC3\xA9\xFF";
  for (int round = 0; round < 2000; ++round) {
    std::string text(random() % 200, '\0');
    for (char& c : text) c = round % 2 == 0 ? static_cast<char>(random() % 256) : alphabet[random() % alphabet.size()];
    ASSERT_TRUE(answered(text, fake_schemas())) << "round " << round;
  }
}

TEST(HostileFiles, ThatNestTooDeepAreRefusedWhereTheyDo) {
  std::string dots = "# fine\n[rig]\n";
  for (int i = 0; i < 200000; ++i) dots += "a.";
  EXPECT_EQ(
      mistakes_in(dots + "a = 1\n"),
      "rig.toml:3:18: this is nested deeper than a rig file may be: expected at most 16 brackets open at a time and 8 "
      "dots in a key\n");
  EXPECT_EQ(
      mistakes_in("x = " + std::string(100000, '[')),
      "rig.toml:1:21: this is nested deeper than a rig file may be: expected at most 16 brackets open at a time and 8 "
      "dots in a key\n");
  std::string quoted_dots = "x";
  for (int i = 0; i < 100; ++i) quoted_dots += " . \"a.b\"";
  EXPECT_TRUE(too_deep(quoted_dots));
}

TEST(HostileFiles, MayHaveDotsAndBracketsInTextAndComments) {
  const std::string many(100, '.');
  const std::string long_text = std::string("x = \"\"\"\n").append(many).append("\"\" \\\"\"\"\" \"\"\"\n");
  for (const std::string& text :
       {"# " + many + "[[[[[[[[[[[[[[[[[[[[", "x = \"" + many + "\\\"" + many + "\"\n", "x = '" + many + "\\'\n",
        long_text, "x = '''" + many + "''''\ny = [1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 9.5, 10.5]\n"}) {
    EXPECT_FALSE(too_deep(text)) << text;
  }
}

TEST(HostileFiles, WithMoreMistakesThanAnyoneReadsAreCutShort) {
  std::string text;
  for (int i = 0; i < 100000; ++i) text.append("k").append(std::to_string(i)).append("=1\n");
  const Result<RigFile> file = parse(text, "rig.toml", fake_schemas());
  ASSERT_FALSE(file);
  ASSERT_EQ(file.error().size(), MistakeList::kMost + 1);
  EXPECT_EQ(file.error().back().message, "and 99004 further mistakes");
}

TEST(HostileFiles, ShowLongTextShortened) {
  const std::string long_word(5000, 'x');
  expect_mistake("\"fixed\"", "@\"" + long_word + "\"",
                 "\"reference\" is \"" + std::string(60, 'x') + "...\": expected \"fixed\", \"tracked\" or \"sync\"");
}

}  // namespace
}  // namespace dwell::config::testing
