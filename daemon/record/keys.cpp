#include "daemon/record/keys.hpp"

#include <fcntl.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "daemon/record/digest.hpp"
#include "daemon/record/regular_file.hpp"

namespace dwell::record {
namespace {

constexpr std::size_t kKeyBytes = 32;
constexpr std::size_t kSignatureBytes = 64;
constexpr std::size_t kKeyHashBytes = 4;
constexpr std::size_t kMaxName = 100;
constexpr char kEd25519 = '\x01';  // C2SP's number of the algorithm
constexpr std::string_view kDash = "\u2014 ";
constexpr std::string_view kPrivate = "PRIVATE+KEY+";

using Pkey = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using Context = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;

const unsigned char* bytes_of(std::string_view text) { return reinterpret_cast<const unsigned char*>(text.data()); }

std::string sha256(std::string_view text) {
  std::string out(sizeof(Digest), '\0');
  EVP_Digest(text.data(), text.size(), reinterpret_cast<unsigned char*>(out.data()), nullptr, EVP_sha256(), nullptr);
  return out;
}

std::string hexadecimal(std::string_view bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (const char byte : bytes) {
    out += kDigits[static_cast<unsigned char>(byte) >> 4];
    out += kDigits[static_cast<unsigned char>(byte) & 15u];
  }
  return out;
}

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= kMaxName &&
         std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < '\x7f' && c != '+'; });
}

std::string key_hash(const std::string& name, std::string_view key) {
  return sha256(name + "\n" + kEd25519 + std::string(key)).substr(0, kKeyHashBytes);
}

// The parts of "NAME+HASH+BASE64".
struct KeyText {
  std::string name, hash, key;
};

Result<KeyText> parse_key_text(std::string_view text) {
  const std::size_t hash_at = text.find('+');
  const std::size_t key_at = hash_at == std::string_view::npos ? hash_at : text.find('+', hash_at + 1);
  if (key_at == std::string_view::npos) return fails("a key is written NAME+HASH+BASE64");
  KeyText parts;
  parts.name = text.substr(0, hash_at);
  parts.hash = text.substr(hash_at + 1, key_at - hash_at - 1);
  if (!is_name(parts.name)) return fails("the name of a key is 1 to 100 visible ASCII characters without +");
  const std::optional<std::string> bytes = from_base64(text.substr(key_at + 1));
  if (!bytes || bytes->size() != 1 + kKeyBytes) return fails("a key ends with 33 bytes in base64");
  if (bytes->front() != kEd25519) return fails("not an Ed25519 key");
  parts.key = bytes->substr(1);
  return parts;
}

std::string key_text(const std::string& name, std::string_view public_key, std::string_view key) {
  return name + "+" + hexadecimal(key_hash(name, public_key)) + "+" + base64(kEd25519 + std::string(key));
}

Result<std::string> public_of(EVP_PKEY* key) {
  std::string out(kKeyBytes, '\0');
  std::size_t length = out.size();
  if (EVP_PKEY_get_raw_public_key(key, reinterpret_cast<unsigned char*>(out.data()), &length) != 1 ||
      length != kKeyBytes)
    return fails("libcrypto cannot use this Ed25519 key");
  return out;
}

}  // namespace

PublicKey::PublicKey(std::string name, std::string key)
    : name_(std::move(name)), key_(std::move(key)), hash_(key_hash(name_, key_)) {}

Result<PublicKey> PublicKey::parse(std::string_view vkey) {
  if (vkey.substr(0, kPrivate.size()) == kPrivate) return fails("this is a private key: keep it to yourself");
  Result<KeyText> parts = parse_key_text(vkey);
  if (!parts) return fails(std::move(parts.error()));
  PublicKey key(std::move(parts->name), std::move(parts->key));
  if (key.vkey() != vkey) return fails("the hash of the key does not fit its name and its bytes");
  return key;
}

std::string PublicKey::vkey() const { return key_text(name_, key_, key_); }

std::string PublicKey::fingerprint() const {
  std::string out;
  const std::string digits = hexadecimal(sha256(key_));
  for (std::size_t i = 0; i < digits.size(); i += 4) out += (i > 0 ? " " : "") + digits.substr(i, 4);
  return out;
}

// Views of a note, and the signature decoded.
struct PublicKey::Parts {
  std::string_view text;
  std::string signature;  // 64 bytes
};

Result<PublicKey::Parts> PublicKey::parts_of(std::string_view note) const {
  // The text ends before the last empty line.
  const std::size_t gap = note.rfind("\n\n");
  if (gap == std::string_view::npos) return fails("not a signed note: no empty line before the signature");
  std::string_view line = note.substr(gap + 2);
  if (line.substr(0, kDash.size()) != kDash || line.back() != '\n')
    return fails("not a signed note: no line of a signature at its end");
  if (line.find('\n') != line.size() - 1) return fails("the note has more lines of signatures than one");
  line = line.substr(kDash.size(), line.size() - kDash.size() - 1);
  if (line.substr(0, name_.size()) != name_ || line.substr(name_.size(), 1) != " ")
    return fails("the note is not signed by \"" + name_ + "\"");
  const std::optional<std::string> signature = from_base64(line.substr(name_.size() + 1));
  if (!signature || signature->size() != kKeyHashBytes + kSignatureBytes)
    return fails("the signature of the note is not 68 bytes in base64");
  if (hash_.empty() || signature->compare(0, kKeyHashBytes, hash_) != 0)
    return fails("the note is signed by another key named \"" + name_ + "\"");
  return Parts{note.substr(0, gap + 1), signature->substr(kKeyHashBytes)};
}

Result<std::string_view> PublicKey::read(std::string_view note) const {
  Result<Parts> parts = parts_of(note);
  if (!parts) return fails(std::move(parts.error()));
  return parts->text;
}

Result<std::string> PublicKey::open(std::string_view note) const {
  Result<Parts> parts = parts_of(note);
  if (!parts) return fails(std::move(parts.error()));
  const Pkey key(EVP_PKEY_new_raw_public_key(EVP_PKEY_ED25519, nullptr, bytes_of(key_), key_.size()), EVP_PKEY_free);
  const Context context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  if (!key || !context || EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr, key.get()) != 1)
    return fails("libcrypto cannot use this Ed25519 key");
  if (EVP_DigestVerify(context.get(), bytes_of(parts->signature), kSignatureBytes, bytes_of(parts->text),
                       parts->text.size()) != 1)
    return fails("the signature does not hold");
  return std::string(parts->text);
}

struct SigningKey::Private {
  Pkey key{nullptr, EVP_PKEY_free};
};

Result<SigningKey> SigningKey::make(const std::string& name) {
  if (!is_name(name)) return fails("the name of a key is 1 to 100 visible ASCII characters without +");
  auto own = std::make_shared<Private>();
  own->key.reset(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
  if (!own->key) return fails("libcrypto makes no key: the system yields no random numbers");
  Result<std::string> public_key = public_of(own->key.get());
  if (!public_key) return fails(std::move(public_key.error()));
  SigningKey key;
  key.key_ = std::move(own);
  key.public_ = PublicKey(name, std::move(*public_key));
  return key;
}

bool SigningKey::is_at(const std::string& path) {
  const Result<OpenFile> file = open_regular(path);
  std::string begin(kPrivate.size(), '\0');
  return file && ::read(file->get(), begin.data(), begin.size()) == static_cast<ssize_t>(begin.size()) &&
         begin == kPrivate;
}

Result<SigningKey> SigningKey::load(const std::string& path) {
  const auto of_file = [&path](const std::string& what) { return fails(path + ": " + what); };
  const Result<OpenFile> file = open_regular(path);
  if (!file) return fails(file.error());
  struct stat status {};
  std::string text(512, '\0');  // more than a key has
  const bool known = ::fstat(file->get(), &status) == 0;
  const ssize_t length = ::read(file->get(), text.data(), text.size());
  if (!known || length < 0) return of_file("cannot be read");
  text.resize(static_cast<std::size_t>(length));
  if (PublicKey::parse(text.substr(0, text.find('\n'))))
    return of_file("is a public key; expected the private key that belongs to it");
  if (text.substr(0, kPrivate.size()) != kPrivate || text.back() != '\n')
    return of_file("not a private key of Dwell: one line PRIVATE+KEY+NAME+HASH+BASE64 was expected");
  if ((status.st_mode & 077u) != 0) return of_file("others than its owner may use this private key; chmod 600 it");
  text.pop_back();
  Result<KeyText> parts = parse_key_text(std::string_view(text).substr(kPrivate.size()));
  if (!parts) return of_file(parts.error());

  auto own = std::make_shared<Private>();
  own->key.reset(EVP_PKEY_new_raw_private_key(EVP_PKEY_ED25519, nullptr, bytes_of(parts->key), parts->key.size()));
  OPENSSL_cleanse(parts->key.data(), parts->key.size());
  OPENSSL_cleanse(text.data(), text.size());
  if (!own->key) return of_file("libcrypto cannot use this Ed25519 key");
  Result<std::string> public_key = public_of(own->key.get());
  if (!public_key) return of_file(public_key.error());
  if (parts->hash != hexadecimal(key_hash(parts->name, *public_key)))
    return of_file("damaged: the hash of the key does not fit its name and its bytes");
  SigningKey key;
  key.key_ = std::move(own);
  key.public_ = PublicKey(std::move(parts->name), std::move(*public_key));
  return key;
}

Result<void> SigningKey::save(const std::string& path) const {
  std::string seed(kKeyBytes, '\0');
  std::size_t length = seed.size();
  if (EVP_PKEY_get_raw_private_key(key_->key.get(), reinterpret_cast<unsigned char*>(seed.data()), &length) != 1)
    return fails(path + ": libcrypto does not hand out this key");
  std::string line = std::string(kPrivate) + key_text(public_.name_, public_.key_, seed) + "\n";
  OPENSSL_cleanse(seed.data(), seed.size());

  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) return fails(path + ": " + std::strerror(errno));
  const bool written =
      ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size()) && ::fsync(file) == 0;
  const int error = errno;
  OPENSSL_cleanse(line.data(), line.size());
  ::close(file);
  if (!written) {
    ::unlink(path.c_str());
    return fails(path + ": " + std::strerror(error));
  }
  // The name of the file is to survive a loss of power as well.
  const std::string directory = std::filesystem::path(path).parent_path().string();
  const int folder = ::open(directory.empty() ? "." : directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);
    ::close(folder);
  }
  return {};
}

std::string SigningKey::sign(std::string_view text) const {
  std::string signature(kSignatureBytes, '\0');
  std::size_t length = signature.size();
  const Context context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  // Fails only if memory is out; the note then does not open.
  if (!context || EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr, key_->key.get()) != 1 ||
      EVP_DigestSign(context.get(), reinterpret_cast<unsigned char*>(signature.data()), &length, bytes_of(text),
                     text.size()) != 1)
    signature.assign(kSignatureBytes, '\0');
  std::string note(text);
  note += "\n";
  note += kDash;
  note += public_.name_ + " " + base64(public_.hash_ + signature) + "\n";
  return note;
}

}  // namespace dwell::record
