// What is wrong with a rig file, and where: the mistakes are collected while reading, sorted, and told all at once.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace dwell::config {

// Line and column count from 1, columns in code points. 0, 0: the file as a whole.
struct Position {
  int line = 0;
  int column = 0;
};

struct Mistake {
  int line = 0;
  int column = 0;
  std::string message;  // one line: what is wrong, what was expected
};

using Mistakes = std::vector<Mistake>;

// What reading a file yields: the thing, or every mistake in it (at least one), sorted by position.
template <class T>
using Result = tl::expected<T, Mistakes>;

// `FILE:LINE:COLUMN: message`; for a mistake of the file as a whole `FILE: message`.
[[nodiscard]] std::string to_string(std::string_view file, const Mistake& mistake);
// One line per mistake, each ended by a newline.
[[nodiscard]] std::string to_string(std::string_view file, const Mistakes& mistakes);

// Collects mistakes; bounded, so that no file can make it grow: beyond kMost they are only counted.
class MistakeList {
 public:
  static constexpr std::size_t kMost = 1000;

  void add(Position at, std::string message);
  // All, counted ones included.
  [[nodiscard]] std::size_t count() const noexcept { return found_.size() + left_out_; }
  // What is added now is only counted: no need to word it.
  [[nodiscard]] bool full() const noexcept { return found_.size() >= kMost; }
  // Sorted by position; the last one says how many were left out, if any were.
  [[nodiscard]] Mistakes sorted() &&;

 private:
  Mistakes found_;
  std::size_t left_out_ = 0;
};

// Text of the file made fit for a message: in quotes, shortened to about 60 bytes, controls replaced.
[[nodiscard]] std::string in_quotes(std::string_view text);
// The same without the quotes, for messages of others, shortened to about 300 bytes.
[[nodiscard]] std::string one_line(std::string_view text);
// The shortest usual form of a number, as in "4.5" or "1e-06".
[[nodiscard]] std::string number_text(double number);

// The name nearest to `wrong`, if near enough to be what was meant (at most `edits` letters wrong, missing, too many or
// swapped with the next); empty: none. Cost O(names · length²), lengths beyond 64 are never near.
[[nodiscard]] std::string nearest_name(std::string_view wrong, const std::vector<std::string>& names,
                                       std::size_t edits = 2);

}  // namespace dwell::config
