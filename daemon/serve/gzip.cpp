#include "daemon/serve/gzip.hpp"

#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <optional>

namespace dwell {
namespace {

constexpr int kGzip = 16;             // added to the window's bits: a gzip header, not zlib's
constexpr int kMemory = 9;            // of 9
constexpr std::size_t kHeaders = 32;  // bytes by which a gzip header and trailer may exceed zlib's: 12

std::string_view trimmed(std::string_view text) noexcept {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

bool same_letters(std::string_view a, std::string_view b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

// "q=0", "q=0.000": not acceptable.
bool refused(std::string_view weight) noexcept {
  if (weight.size() < 3 || !same_letters(weight.substr(0, 2), "q=")) return false;
  return weight.find_first_not_of("0.", 2) == std::string_view::npos;
}

}  // namespace

std::string gzip_of(std::string_view bytes) {
  std::string packed(compressBound(static_cast<uLong>(bytes.size())) + kHeaders, '\0');
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, MAX_WBITS + kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // zlib does not write there
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const bool whole = deflate(&stream, Z_FINISH) == Z_STREAM_END;
  packed.resize(whole ? stream.total_out : 0);
  deflateEnd(&stream);
  return packed;
}

bool accepts_gzip(std::string_view accepted) noexcept {
  std::optional<bool> by_name, by_all;
  while (!accepted.empty()) {
    const std::string_view one = accepted.substr(0, accepted.find(','));
    accepted.remove_prefix(std::min(accepted.size(), one.size() + 1));
    const auto mark = one.find(';');
    const std::string_view name = trimmed(one.substr(0, mark));
    const bool taken = mark == std::string_view::npos || !refused(trimmed(one.substr(mark + 1)));
    if (same_letters(name, "gzip")) by_name = taken;
    if (name == "*") by_all = taken;
  }
  return by_name.value_or(by_all.value_or(false));
}

}  // namespace dwell
