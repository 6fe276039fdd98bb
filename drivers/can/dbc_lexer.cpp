#include "drivers/can/dbc_lexer.hpp"

#include <algorithm>

namespace dwell::can {
namespace {

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }
// Names are C identifiers; what some tools write beyond ASCII is taken as part of one.
bool is_word(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || is_digit(c) ||
         static_cast<unsigned char>(c) >= 0x80;
}

}  // namespace

std::string Token::shown() const {
  if (kind == Kind::end) return "the end of the file";
  constexpr std::size_t kMost = 40;
  const bool quoted = kind == Kind::text || kind == Kind::open;
  std::string shown(quoted ? "`\"" : "`");
  for (const char c : text.substr(0, kMost)) shown += c >= ' ' && c <= '~' ? c : '?';
  if (text.size() > kMost) shown += "…";
  return shown + (kind == Kind::text ? "\"`" : "`");
}

Lexer::Lexer(std::string_view text) : text_(text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text_.substr(0, kByteOrderMark.size()) == kByteOrderMark) at_ = line_begin_ = kByteOrderMark.size();
  next();
}

void Lexer::skip_blanks() noexcept {
  for (; at_ < text_.size(); ++at_) {
    const char c = text_[at_];
    if (c == '\n') {
      ++line_;
      line_begin_ = at_ + 1;
      first_ = true;
    } else if (c != ' ' && c != '\t' && c != '\r' && c != '\f' && c != '\v') {
      return;
    }
  }
}

// At the opening quote. A quote within is written \".
void Lexer::take_text() noexcept {
  const std::size_t begin = ++at_;
  for (; at_ < text_.size() && text_[at_] != '"'; ++at_) {
    if (text_[at_] == '\\' && at_ + 1 < text_.size() && text_[at_ + 1] == '"') ++at_;
    if (text_[at_] == '\n') {
      ++line_;
      line_begin_ = at_ + 1;
    }
  }
  token_.kind = at_ < text_.size() ? Token::Kind::text : Token::Kind::open;
  token_.text = text_.substr(begin, at_ - begin);
  if (at_ < text_.size()) ++at_;
}

void Lexer::next_line() noexcept {
  if (token_.kind == Token::Kind::end) return;
  const auto begin = static_cast<std::size_t>(token_.text.data() - text_.data());
  line_ = token_.line;
  at_ = std::min(text_.find('\n', begin), text_.size());
  first_ = true;  // the blank that ends the line is skipped, and counted, as any other
  next();
}

void Lexer::next() noexcept {
  skip_blanks();
  token_ = {Token::Kind::end, {}, line_, at_ - line_begin_ + 1, first_};
  first_ = false;
  if (at_ >= text_.size()) return;
  const std::size_t begin = at_;
  const auto peek = [&](std::size_t ahead) { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; };
  const char c = peek(0);
  if (c == '"') return take_text();
  const bool is_signed = c == '+' || c == '-';
  if (is_digit(c) || ((is_signed || c == '.') && is_digit(peek(1))) ||
      (is_signed && peek(1) == '.' && is_digit(peek(2)))) {
    token_.kind = Token::Kind::number;
    for (++at_; at_ < text_.size(); ++at_) {
      const bool exponent = (peek(0) == '+' || peek(0) == '-') && (text_[at_ - 1] == 'e' || text_[at_ - 1] == 'E');
      if (!is_word(peek(0)) && peek(0) != '.' && !exponent) break;
    }
  } else if (is_word(c)) {
    token_.kind = Token::Kind::word;
    while (is_word(peek(0))) ++at_;
  } else {
    token_.kind = Token::Kind::sign;
    ++at_;
  }
  token_.text = text_.substr(begin, at_ - begin);
}

}  // namespace dwell::can
