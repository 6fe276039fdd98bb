// Ed25519 keys and the text forms of C2SP: public keys ("vkey") and signed notes. Each thing has one form: what is
// written otherwise, by one bit, is refused. A name is 1 to 100 visible ASCII characters, "+" not among them.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace dwell::record {

template <class T>
using Result = tl::expected<T, std::string>;

// A public key with its name. A value; any thread.
class PublicKey {
 public:
  // From the text of a vkey; fails with what is wrong.
  [[nodiscard]] static Result<PublicKey> parse(std::string_view vkey);
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  // "NAME+1a2b3c4d+BASE64", one line.
  [[nodiscard]] std::string vkey() const;
  // SHA-256 of the 32 bytes of the key, as 16 groups of four hexadecimal digits: what people compare.
  [[nodiscard]] std::string fingerprint() const;
  // The signed text of a note, without the signature line, its last newline included. Fails where the note is not by
  // this key alone, where the signature does not hold, or where it has bytes that no note has. Cost: 0.15 ms.
  [[nodiscard]] Result<std::string> open(std::string_view note) const;
  bool operator==(const PublicKey&) const = default;

 private:
  friend class SigningKey;
  std::string name_;
  std::string key_;  // 32 bytes
};

// A private key with its name: the service's, or a person's. Bound to one thread.
class SigningKey {
 public:
  // A new one. Fails where the name is none, or the system yields no random numbers.
  [[nodiscard]] static Result<SigningKey> make(const std::string& name);
  // From a file written by save(); fails with the reason, also where others than the owner may read it. The file's one
  // line is "PRIVATE+KEY+NAME+1a2b3c4d+BASE64", as Go's note package writes keys.
  [[nodiscard]] static Result<SigningKey> load(const std::string& path);
  // Writes a new file, mode 0600, synchronized to the disk; fails where there is one already.
  [[nodiscard]] Result<void> save(const std::string& path) const;
  [[nodiscard]] const PublicKey& public_key() const noexcept { return public_; }
  // The note: text (which ends with a newline), an empty line, the signature line.
  [[nodiscard]] std::string sign(std::string_view text) const;

 private:
  struct Private;
  std::shared_ptr<const Private> key_;
  PublicKey public_;
};

}  // namespace dwell::record
