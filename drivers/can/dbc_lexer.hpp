// A DBC file's text as tokens with positions. Pure, no copy of the text is made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace dwell::can {

struct Token {
  enum class Kind : std::uint8_t {
    word,
    number,  // begins like one; need not be one
    text,    // without its quotes
    sign,    // any other character
    open,    // a text whose end is missing
    end
  };
  Kind kind = Kind::end;
  std::string_view text;
  std::size_t line = 1, column = 1;
  bool first = true;  // of its line

  [[nodiscard]] bool is(char sign) const noexcept { return kind == Kind::sign && text[0] == sign; }
  [[nodiscard]] bool is(std::string_view word) const noexcept { return kind == Kind::word && text == word; }
  // A text that does not end on its line.
  [[nodiscard]] bool spans_lines() const noexcept {
    return kind == Kind::open || (kind == Kind::text && text.find('\n') != std::string_view::npos);
  }
  // For people: the token in back quotes, shortened, what is not ASCII as `?`.
  [[nodiscard]] std::string shown() const;
};

// A copy is a mark to return to.
class Lexer {
 public:
  explicit Lexer(std::string_view text);
  [[nodiscard]] const Token& now() const noexcept { return token_; }
  // Goes on to the next one; at the end it stays there.
  void next() noexcept;
  // Goes on at the line behind the one on which the present token begins: what followed was no part of a text after
  // all.
  void next_line() noexcept;

 private:
  void skip_blanks() noexcept;
  void take_text() noexcept;

  std::string_view text_;
  std::size_t at_ = 0, line_ = 1, line_begin_ = 0;
  bool first_ = true;
  Token token_;
};

}  // namespace dwell::can
