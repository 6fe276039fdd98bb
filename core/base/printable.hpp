// Text from outside (names, reasons, comments) made fit to be shown: no terminal obeys it, and it is read in the order
// in which it is stored. Text is UTF-8; other bytes stay as they are. Thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dwell {

// A control of the writing direction (Unicode 15.1, UAX #9), with which a name could show its letters, and the text
// beside it, in another order; or a separator of lines or paragraphs.
[[nodiscard]] constexpr bool turns_text(unsigned code) noexcept {
  return code == 0x2028 || code == 0x2029 || code == 0x061C || code == 0x200E || code == 0x200F ||
         (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

// Bytes of the control at the beginning of `text`: U+0000 … U+001F, U+007F … U+009F, or one of the writing direction.
// 0: there is none.
[[nodiscard]] constexpr std::size_t control_bytes(std::string_view text) noexcept {
  const auto byte = [text](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const auto continues = [&byte](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const unsigned first = byte(0);
  if (text.empty()) return 0;
  if (first < 0x20 || first == 0x7F) return 1;
  if ((first & 0xE0U) == 0xC0U && continues(1)) {
    const unsigned code = (first & 0x1FU) << 6U | (byte(1) & 0x3FU);
    return code < 0xA0 || turns_text(code) ? 2 : 0;
  }
  if ((first & 0xF0U) == 0xE0U && continues(1) && continues(2))
    return turns_text((first & 0x0FU) << 12U | (byte(1) & 0x3FU) << 6U | (byte(2) & 0x3FU)) ? 3 : 0;
  return 0;
}

[[nodiscard]] constexpr bool has_control(std::string_view text) noexcept {
  for (; !text.empty(); text.remove_prefix(1))
    if (control_bytes(text) > 0) return true;
  return false;
}

// The text with `instead` for each control.
[[nodiscard]] inline std::string printable(std::string_view text, char instead = '?') {
  std::string clean;
  clean.reserve(text.size());
  while (!text.empty()) {
    const std::size_t control = control_bytes(text);
    clean += control > 0 ? instead : text.front();
    text.remove_prefix(control > 0 ? control : 1);
  }
  return clean;
}

}  // namespace dwell
