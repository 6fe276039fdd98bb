#include "config/nesting.hpp"

namespace dwell::config {
namespace {

// End of the quoted text that begins at `at`: the index behind its closing quotes, or of the line end that breaks it
// off.
std::size_t skip_quoted(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string_view three = quote == '"' ? "\"\"\"" : "'''";
  const bool long_form = text.substr(at, 3) == three;
  std::size_t i = at + (long_form ? 3 : 1);
  while (i < text.size()) {
    if (quote == '"' && text[i] == '\\') {
      i += 2;
    } else if (long_form && text.substr(i, 3) == three) {
      i += 3;
      // Up to two quotes may stand before the closing three.
      for (int extra = 0; extra < 2 && i < text.size() && text[i] == quote; ++extra) ++i;
      return i;
    } else if (!long_form && text[i] == quote) {
      return i + 1;
    } else if (!long_form && text[i] == '\n') {
      return i;
    } else {
      ++i;
    }
  }
  return text.size();
}

Position position_of(std::string_view text, std::size_t index) {
  Position at{1, 1};
  for (const char c : text.substr(0, index)) {
    if (c == '\n') {
      ++at.line;
      at.column = 1;
    } else if ((static_cast<unsigned char>(c) & 0xC0u) != 0x80u) {
      ++at.column;
    }
  }
  return at;
}

}  // namespace

std::optional<Position> too_deep(std::string_view text) {
  int brackets = 0;
  int dots = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      i = skip_quoted(text, i);
      continue;
    }
    if (c == '#') {
      i = text.find('\n', i);
      if (i == std::string_view::npos) break;
      continue;
    }
    if (c == '[' || c == '{') {
      ++brackets;
      dots = 0;
    } else if (c == ']' || c == '}') {
      if (brackets > 0) --brackets;
    } else if (c == '.') {
      ++dots;
    } else if (c == '\n' || c == ',' || c == '=') {
      dots = 0;
    }
    if (brackets > kMaxBrackets || dots > kMaxDots) return position_of(text, i);
    ++i;
  }
  return std::nullopt;
}

}  // namespace dwell::config
