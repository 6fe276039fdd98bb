// The token: a secret of the installation. Whoever knows it may read and change something over HTTP.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace dwell {

// Only its SHA-256 is kept, so a dump of the process's memory does not reveal it. Thread-safe.
class Token {
 public:
  // 128 bits where the characters are random hexadecimal digits (openssl rand -hex 16). 10 000 guesses a second for a
  // year are 2^38 of 2^128. The length is the protection: wrong tokens are counted and logged, but nobody is locked
  // out. A lock-out would let any client keep the operators out.
  static constexpr std::size_t kFewest = 32;
  // Longer ones protect no better. The header of a request holds 8 KiB.
  static constexpr std::size_t kMost = 256;

  // Of the file at `path`, one line. Fails with what was found and what is expected, in one line.
  static tl::expected<Token, std::string> read(const std::string& path);
  explicit Token(std::string_view text);

  // Compares in a time that does not depend on where the texts differ.
  [[nodiscard]] bool is(std::string_view text) const;
  friend bool operator==(const Token& a, const Token& b) { return a.sha256_ == b.sha256_; }

 private:
  std::string sha256_;  // hexadecimal
};

// Why the user cannot read the token file, and what to do, in one line. Root asks this before it says that a rig file
// is right: root itself may read every file. Empty: the user can read it, there is no such user, the path names no
// file, or whoever asks is not root.
//
// Becomes that user for a moment: only for a process with one thread.
[[nodiscard]] std::string unreadable_token_note(const std::string& path, const std::string& user);

}  // namespace dwell
