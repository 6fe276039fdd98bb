// Content in gzip (RFC 1952) for HTTP. Thread-safe; allocates.
#pragma once

#include <string>
#include <string_view>

namespace dwell {

// The bytes packed at the best level: some ms for 100 kB. Empty: they cannot be packed.
[[nodiscard]] std::string gzip_of(std::string_view bytes);

// Whether a client takes gzip, by its field Accept-Encoding (RFC 9110, 12.5.3): it names gzip, or all by "*", at a
// weight above 0. accepted: any bytes, read up to the first that do not fit; empty: there is no such field, so the
// content goes as it is.
[[nodiscard]] bool accepts_gzip(std::string_view accepted);

}  // namespace dwell
