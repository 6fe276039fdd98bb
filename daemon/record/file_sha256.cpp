#include "daemon/record/file_sha256.hpp"

#include <openssl/evp.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <stdexcept>
#include <vector>

#include "daemon/record/digest.hpp"
#include "daemon/record/regular_file.hpp"

namespace dwell::record {
namespace {

constexpr std::size_t kPiece = 65536;  // larger ones are not faster

}  // namespace

Result<std::optional<std::string>> file_sha256(const std::string& path, std::uintmax_t most) {
  const Result<OpenFile> file = open_regular(path);
  if (!file) return tl::unexpected(file.error());
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> sum(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  bool works = sum && EVP_DigestInit_ex(sum.get(), EVP_sha256(), nullptr) == 1;
  std::vector<char> piece(kPiece);
  std::uintmax_t bytes = 0;
  for (ssize_t count = 0; (count = read(file->get(), piece.data(), piece.size())) != 0;) {
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return tl::unexpected(path + ": " + system_text(errno));
    bytes += static_cast<std::uintmax_t>(count);
    if (bytes > most) return std::nullopt;
    works = works && EVP_DigestUpdate(sum.get(), piece.data(), static_cast<std::size_t>(count)) == 1;
  }
  Digest digest{};
  // Fails only if the library was built without SHA-256 or memory is out.
  if (!works || EVP_DigestFinal_ex(sum.get(), digest.data(), nullptr) != 1)
    throw std::runtime_error("SHA-256 is not available from libcrypto");
  return hex(digest);
}

}  // namespace dwell::record
