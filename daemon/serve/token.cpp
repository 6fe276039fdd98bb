#include "daemon/serve/token.hpp"

#include <openssl/crypto.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "config/sha256.hpp"
#include "daemon/record/small_file.hpp"

namespace dwell {
namespace {

// The largest file that is read. Far more than a token, so that a token that is too long is told as one.
constexpr std::size_t kMostBytes = 4096;

std::string octal(mode_t mode) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%04o", static_cast<unsigned>(mode & 07777U));
  return text.data();
}

}  // namespace

tl::expected<Token, std::string> Token::read(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) == 0 && (status.st_mode & S_IRWXO) != 0 && S_ISREG(status.st_mode))
    return tl::unexpected("is open to every user of this computer (mode " + octal(status.st_mode) +
                          "): expected 0640 or less; chmod o= it, and put another token in");
  auto text = record::read_small_file(path, kMostBytes);
  if (!text) return tl::unexpected("cannot be read: " + text.error().substr(path.size() + 2));  // behind "PATH: "
  if (!text->empty() && text->back() == '\n') text->pop_back();
  const std::string expected = ": expected one line of " + std::to_string(kFewest) + " to " + std::to_string(kMost) +
                               " characters; openssl rand -hex 16 makes one";
  if (text->size() < kFewest)
    return tl::unexpected("holds a token of " + std::to_string(text->size()) + " characters" + expected);
  if (text->size() > kMost) return tl::unexpected("holds more than a token" + expected);
  // What a header carries unchanged.
  if (!std::all_of(text->begin(), text->end(), [](char c) { return c > ' ' && c < 0x7f; }))
    return tl::unexpected("holds a space, a second line or what is not ASCII" + expected);
  return Token(*text);
}

Token::Token(std::string_view text) : sha256_(config::sha256(text)) {}

bool Token::is(std::string_view text) const {
  const std::string other = config::sha256(text);
  return CRYPTO_memcmp(sha256_.data(), other.data(), sha256_.size()) == 0;
}

}  // namespace dwell
