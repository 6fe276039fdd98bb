// The token: a secret of the installation. Who knows it may change something over HTTP.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace dwell {

// Only its SHA-256 is kept, so no dump of the process's memory hands it out. Thread-safe.
class Token {
 public:
  // 128 bits even where the characters are hexadecimal digits (openssl rand -hex 16). Guessed 10 000 times a second,
  // more than this server answers, a year reaches 2^38 of 2^128. The protection is this length: wrong tokens are
  // counted and logged, but nobody is locked out, since whoever can lock out a guesser can lock out the operators.
  static constexpr std::size_t kFewest = 32;
  // Longer ones protect no better. The header of a request holds 8 KiB.
  static constexpr std::size_t kMost = 256;

  // Fails with what was found and what is expected, in one line.
  static tl::expected<Token, std::string> read(const std::string& path);
  explicit Token(std::string_view text);

  // In a time that does not depend on where they differ.
  [[nodiscard]] bool is(std::string_view text) const;
  friend bool operator==(const Token& a, const Token& b) { return a.sha256_ == b.sha256_; }

 private:
  std::string sha256_;  // hexadecimal
};

}  // namespace dwell
