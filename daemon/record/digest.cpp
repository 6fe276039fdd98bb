#include "daemon/record/digest.hpp"

#include <openssl/evp.h>

#include <charconv>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <utility>

namespace dwell::record {
namespace {

void append_u64(std::string& to, std::uint64_t value) {
  for (int i = 0; i < 8; ++i) to += static_cast<char>(value >> (8 * i) & 0xffu);
}

// Of the parts one after the other. Looking the algorithm up and making a context cost more than a short text does.
Digest sha256(std::initializer_list<std::string_view> parts) {
  using Context = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;
  static EVP_MD* const kAlgorithm = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  thread_local const Context context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  Digest digest{};
  unsigned int length = 0;
  bool done = kAlgorithm != nullptr && context && EVP_DigestInit_ex(context.get(), kAlgorithm, nullptr) == 1;
  for (const std::string_view part : parts)
    done = done && EVP_DigestUpdate(context.get(), part.data(), part.size()) == 1;
  // Fails only if the library was built without SHA-256 or memory is out.
  if (!done || EVP_DigestFinal_ex(context.get(), digest.data(), &length) != 1 || length != digest.size())
    throw std::runtime_error("SHA-256 is not available from libcrypto");
  return digest;
}

}  // namespace

Digest next_head(const Digest& before, const Entry& entry) {
  std::string front = "dwell entry v1\n";
  front.append(reinterpret_cast<const char*>(before.data()), before.size());
  append_u64(front, static_cast<std::uint64_t>(entry.seq));
  append_u64(front, entry.kind.size());
  front += entry.kind;
  append_u64(front, static_cast<std::uint64_t>(entry.t_ns));
  append_u64(front, entry.body.size());
  return sha256({front, entry.body});
}

Digest note_hash(std::string_view note) { return sha256({"dwell note v1\n", note}); }

std::string hex(const Digest& digest) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (const std::uint8_t byte : digest) {
    out += kDigits[byte >> 4];
    out += kDigits[byte & 15u];
  }
  return out;
}

std::string base64(std::string_view bytes) {
  std::string out(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  out.resize(static_cast<std::size_t>(length));
  return out;
}

std::optional<Digest> from_hex(std::string_view text) {
  Digest digest{};
  if (text.size() != 2 * digest.size()) return std::nullopt;
  for (std::size_t i = 0; i < digest.size(); ++i) {
    const auto [end, error] = std::from_chars(text.data() + 2 * i, text.data() + 2 * i + 2, digest[i], 16);
    if (error != std::errc() || end != text.data() + 2 * i + 2) return std::nullopt;
  }
  // Capitals would be a second form of the same digest.
  return hex(digest) == text ? std::optional(digest) : std::nullopt;
}

std::optional<std::string> from_base64(std::string_view text) {
  std::string out(text.size() / 4 * 3, '\0');
  const int length =
      EVP_DecodeBlock(reinterpret_cast<unsigned char*>(out.data()), reinterpret_cast<const unsigned char*>(text.data()),
                      static_cast<int>(text.size()));
  if (length < 0) return std::nullopt;
  out.resize(static_cast<std::size_t>(length));
  for (std::size_t i = text.size(); i > 0 && text[i - 1] == '=' && !out.empty(); --i) out.pop_back();
  // libcrypto forgives spaces and bits beyond the last byte.
  return base64(out) == text ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace dwell::record
