// Text for people as lines: each with what its looks shall say, so that a terminal can show it in colour, in grey or
// inverse, and a pipe as it stands. The meaning is always in the words as well.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace dwell {

enum class Style : std::uint8_t {
  plain,
  title,      // of a table
  old,        // numbers that are no longer renewed
  past,       // numbers of a dwell that has ended: a result
  tentative,  // numbers that are no verdict
  doubted,    // numbers that must not be relied on
  alarm,      // what an operator must see first
  hint,       // the keys
};

struct TextLine {
  std::string text;  // UTF-8, no line end, no control characters
  Style style = Style::plain;
};

// Lines that belong together. Where they go on overleaf, `head` is repeated above them.
struct Section {
  std::vector<TextLine> head;
  std::vector<TextLine> body;
  std::string_view name;  // a literal: what it is, for those who must find it again
  std::size_t notes = 0;  // so many lines at the end of `body` may go overleaf alone, without `head`
};

inline constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();  // width: no line is broken

// The first `columns` code points; where there are more, the last one shown is "…".
[[nodiscard]] std::string clipped(std::string_view text, std::size_t columns);

// The text broken at blanks into lines of at most `columns` code points (at least 8), each but the first behind
// `indent` blanks. A word longer than a line is broken where the line ends: nothing is lost.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, std::size_t columns, std::size_t indent = 0);

// Lines, each with its end, a blank line between sections.
[[nodiscard]] std::string plain_text(const std::vector<Section>& sections);

}  // namespace dwell
