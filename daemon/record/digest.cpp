#include "daemon/record/digest.hpp"

#include <openssl/evp.h>

#include <charconv>
#include <memory>
#include <stdexcept>
#include <utility>

namespace dwell::record {
namespace {

void append_u64(std::string& to, std::uint64_t value) {
  for (int i = 0; i < 8; ++i) to += static_cast<char>(value >> (8 * i) & 0xffu);
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
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  Digest head{};
  unsigned int length = 0;
  // Fails only if the library was built without SHA-256 or memory is out.
  if (!context || EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) != 1 ||
      EVP_DigestUpdate(context.get(), front.data(), front.size()) != 1 ||
      EVP_DigestUpdate(context.get(), entry.body.data(), entry.body.size()) != 1 ||
      EVP_DigestFinal_ex(context.get(), head.data(), &length) != 1 || length != head.size())
    throw std::runtime_error("SHA-256 is not available from libcrypto");
  return head;
}

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
