// Ed25519 keys and the text forms of C2SP: public keys ("vkey") and signed notes. A key or note has exactly one text;
// any other text, different by one bit or by white space, is refused. A name has 1 to 100 visible ASCII characters
// without "+".
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "daemon/record/result.hpp"

namespace dwell::record {

// A public key with its name. A value; any thread.
class PublicKey {
 public:
  PublicKey() = default;  // none: no note is by it
  // From the text of a vkey; fails with what is wrong.
  [[nodiscard]] static Result<PublicKey> parse(std::string_view vkey);
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  // "NAME+1a2b3c4d+BASE64", one line.
  [[nodiscard]] std::string vkey() const;
  // For people to compare: SHA-256 of the 32 bytes of the key, as 16 groups of four hexadecimal digits.
  [[nodiscard]] std::string fingerprint() const;
  // The signed text of a note: all before the empty line and the signature line, with its last newline. Fails if the
  // note has not the form of a note, has more than one signature, names another key, or does not verify. Cost: 0.1 ms.
  [[nodiscard]] Result<std::string> open(std::string_view note) const;
  // The same text, a part of `note`, WITHOUT verifying the signature: anybody can have written it. Cost: 1 µs.
  [[nodiscard]] Result<std::string_view> read(std::string_view note) const;
  bool operator==(const PublicKey& other) const { return name_ == other.name_ && key_ == other.key_; }

 private:
  friend class SigningKey;
  struct Parts;
  PublicKey(std::string name, std::string key);
  [[nodiscard]] Result<Parts> parts_of(std::string_view note) const;

  std::string name_;
  std::string key_;   // 32 bytes
  std::string hash_;  // 4 bytes, of both
};

// A private key with its name: the service's, or a person's. Bound to one thread.
class SigningKey {
 public:
  // Makes a new key. Fails if the name is not allowed, or the system yields no random numbers.
  [[nodiscard]] static Result<SigningKey> make(const std::string& name);
  // Whether the file at `path` begins as a private key does.
  [[nodiscard]] static bool is_at(const std::string& path);
  // Reads a file written by save(). Fails with the reason, also if others than the owner may read the file. Its one
  // line is "PRIVATE+KEY+NAME+1a2b3c4d+BASE64", as Go's note package writes keys.
  [[nodiscard]] static Result<SigningKey> load(const std::string& path);
  // Writes a new file, mode 0600, synchronized to the disk; fails where there is one already.
  [[nodiscard]] Result<void> save(const std::string& path) const;
  [[nodiscard]] const PublicKey& public_key() const noexcept { return public_; }
  // The note: `text` (must end with a newline), an empty line, the signature line. If libcrypto cannot sign for want of
  // memory, the note does not verify.
  [[nodiscard]] std::string sign(std::string_view text) const;

 private:
  struct Private;
  std::shared_ptr<const Private> key_;
  PublicKey public_;
};

}  // namespace dwell::record
