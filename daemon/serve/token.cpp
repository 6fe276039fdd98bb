#include "daemon/serve/token.hpp"

#include <fcntl.h>
#include <openssl/crypto.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "config/sha256.hpp"

namespace dwell {
namespace {

using Text = tl::expected<std::string, std::string>;

std::string octal(mode_t mode) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%04o", static_cast<unsigned>(mode & 07777U));
  return text.data();
}

// One byte more than a token and its end of line may have: what is longer is seen to be.
Text bytes_of(int file, const std::string& cannot) {
  struct stat status {};
  if (file < 0 || fstat(file, &status) != 0) return tl::unexpected(cannot + std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return tl::unexpected(std::string("is no regular file: expected a file with one line"));
  if ((status.st_mode & S_IRWXO) != 0)
    return tl::unexpected("is open to every user of this computer (mode " + octal(status.st_mode) +
                          "): expected 0640 or less; chmod o= it, and put another token in");
  std::array<char, Token::kMost + 2> buffer{};
  std::size_t size = 0;
  while (size < buffer.size()) {
    const ssize_t got = read(file, buffer.data() + size, buffer.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return tl::unexpected(cannot + std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  return std::string(buffer.data(), size);
}

}  // namespace

tl::expected<Token, std::string> Token::read(const std::string& path) {
  // Non-blocking, so that a named pipe is refused rather than waited for.
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  Text text = bytes_of(file, "cannot be read: ");
  if (file >= 0) close(file);
  if (!text) return tl::unexpected(text.error());
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
