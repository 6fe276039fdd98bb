#include "config/listen_address.hpp"

#include <arpa/inet.h>

#include <charconv>

namespace dwell::config {

std::optional<ListenAddress> split_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  std::string host = text.substr(0, colon);
  unsigned char binary[16];
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
    if (inet_pton(AF_INET6, host.c_str(), binary) != 1) return std::nullopt;
  } else if (inet_pton(AF_INET, host.c_str(), binary) != 1 && host != "localhost") {
    return std::nullopt;
  }
  const char* const first = text.data() + colon + 1;
  const char* const last = text.data() + text.size();
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(first, last, port);
  if (first == last || error != std::errc() || end != last) return std::nullopt;
  return ListenAddress{text, host, port};
}

}  // namespace dwell::config
