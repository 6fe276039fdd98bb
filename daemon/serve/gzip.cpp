#include "daemon/serve/gzip.hpp"

#include <zlib.h>

#include <boost/beast/core/string.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <cstddef>
#include <optional>

namespace dwell {
namespace {

constexpr int kGzip = 16;             // added to the window's bits: a gzip header, not zlib's
constexpr int kMemory = 9;            // of 9
constexpr std::size_t kHeaders = 32;  // bytes by which a gzip header and trailer may exceed zlib's: 12

// "0", "0.000": not acceptable.
bool is_zero(std::string_view weight) noexcept {
  return !weight.empty() && weight.find_first_not_of("0.") == std::string_view::npos;
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

bool accepts_gzip(std::string_view accepted) {
  namespace beast = boost::beast;
  std::optional<bool> by_name, by_all;
  for (const auto& [name, parameters] : beast::http::ext_list{{accepted.data(), accepted.size()}}) {
    bool taken = true;
    for (const auto& [parameter, value] : parameters)
      if (beast::iequals(parameter, "q")) taken = !is_zero({value.data(), value.size()});
    if (beast::iequals(name, "gzip")) by_name = taken;
    if (name == "*") by_all = taken;
  }
  return by_name.value_or(by_all.value_or(false));
}

}  // namespace dwell
