#include "daemon/record/utf8.hpp"

#include <array>
#include <cstdio>

namespace dwell::record {
namespace {

// Where the first byte stands that begins no character; the end: there is none.
std::size_t valid_bytes(std::string_view text) noexcept {
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t length = utf8_character(text.substr(at));
    if (length == 0) return at;
    at += length;
  }
  return at;
}

}  // namespace

std::size_t utf8_character(std::string_view text) noexcept {
  if (text.empty()) return 0;
  const auto first = static_cast<unsigned char>(text.front());
  if (first < 0x80) return 1;
  unsigned char least = 0x80, most = 0xBF;  // of the second byte
  if (first == 0xE0) least = 0xA0;
  if (first == 0xED) most = 0x9F;
  if (first == 0xF0) least = 0x90;
  if (first == 0xF4) most = 0x8F;
  const std::size_t length = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
  if (text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c < least || c > most) return 0;
    least = 0x80;
    most = 0xBF;
  }
  return length;
}

bool is_utf8(std::string_view text) noexcept { return valid_bytes(text) == text.size(); }

std::string why_not_utf8(std::string_view text) {
  const std::size_t at = valid_bytes(text);
  if (at == text.size()) return {};
  std::array<char, 8> byte{};
  std::snprintf(byte.data(), byte.size(), "0x%02X", static_cast<unsigned char>(text[at]));
  return "byte " + std::to_string(at + 1) + " is " + byte.data() + ", expected text in UTF-8";
}

}  // namespace dwell::record
