#include "daemon/record/bounded_lines.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

std::vector<std::string> lines_of(BoundedLines& file) {
  std::vector<std::string> lines;
  for (std::string line; file.next(line);) {
    EXPECT_LE(line.size(), BoundedLines::kLine);
    lines.push_back(line);
  }
  return lines;
}

TEST(BoundedLines, AreThoseOfTheFileWithAndWithoutALastNewline) {
  const Scratch scratch;
  for (const std::size_t length : {0U, 1U, 1022U, 1023U, 1024U, 2046U, 4095U, 4096U})
    for (const char* end : {"", "\n"}) {
      const std::string text(length, 'x');
      BoundedLines file(scratch.write("f", "first\n" + text + "\n\nlast" + end), 1'000'000, "words");
      EXPECT_EQ(lines_of(file), (std::vector<std::string>{"first", text, "", "last"})) << length;
      EXPECT_TRUE(file.ended());
    }
}

TEST(BoundedLines, AreCutWhereTheyAreTooLongAndSaySo) {
  const Scratch scratch;
  BoundedLines file(scratch.write("f", std::string(10'000'000, 'x') + "\nlast\n"), 20'000'000, "words");
  std::string line;
  ASSERT_TRUE(file.next(line));
  EXPECT_TRUE(file.cut());
  EXPECT_EQ(line, std::string(BoundedLines::kLine, 'x'));
  ASSERT_TRUE(file.next(line));
  EXPECT_FALSE(file.cut());
  EXPECT_EQ(line, "last");
}

TEST(BoundedLines, EndWhereTheFileIsTooLarge) {
  const Scratch scratch;
  const std::string path = scratch.write("f", std::string(3000, 'x') + "\n");
  BoundedLines just(path, 3001, "words"), less(path, 3000, "words");
  EXPECT_EQ(lines_of(just).size(), 1U);
  EXPECT_TRUE(just.ended());
  EXPECT_TRUE(lines_of(less).empty());
  EXPECT_EQ(less.ended().error(), path + ": has more than 3000 bytes; expected a file of words");
}

TEST(BoundedLines, OfWhatCannotBeReadAreNoEmptyFile) {
  BoundedLines folder("/proc", 1000, "words");
  EXPECT_TRUE(lines_of(folder).empty());
  EXPECT_TRUE(!folder.is_open() || !folder.ended());
}

}  // namespace
}  // namespace dwell::record
