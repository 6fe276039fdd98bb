#include "config/listen_address.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <charconv>

namespace dwell::config {
namespace {

// The address of a ListenAddress as IPv6; IPv4 is mapped to ::ffff:a.b.c.d.
in6_addr binary_of(const std::string& host) {
  in6_addr binary{};
  if (inet_pton(AF_INET6, host.c_str(), &binary) == 1) return binary;
  const std::string mapped = "::ffff:" + (host == "localhost" ? "127.0.0.1" : host);
  inet_pton(AF_INET6, mapped.c_str(), &binary);
  return binary;
}

bool covers(const in6_addr& a, const in6_addr& b) {
  const in6_addr all_v4 = binary_of("0.0.0.0");
  return IN6_IS_ADDR_UNSPECIFIED(&a) || IN6_ARE_ADDR_EQUAL(&a, &b) ||
         (IN6_ARE_ADDR_EQUAL(&a, &all_v4) && IN6_IS_ADDR_V4MAPPED(&b));
}

}  // namespace

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

bool is_multicast_or_broadcast(const std::string& host) {
  const in6_addr binary = binary_of(host);
  if (!IN6_IS_ADDR_V4MAPPED(&binary)) return IN6_IS_ADDR_MULTICAST(&binary);
  constexpr unsigned kMulticast = 0xE0;  // 224.0.0.0/4
  const bool broadcast = std::all_of(binary.s6_addr + 12, binary.s6_addr + 16, [](auto byte) { return byte == 0xFF; });
  return (binary.s6_addr[12] & 0xF0U) == kMulticast || broadcast;
}

bool beyond_loopback(const std::string& host) {
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24U) != 127;
  in6_addr v6{};
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) return !IN6_IS_ADDR_LOOPBACK(&v6);
  return false;  // localhost
}

bool collide(const ListenAddress& a, const ListenAddress& b) {
  const in6_addr of_a = binary_of(a.host), of_b = binary_of(b.host);
  return a.port != 0 && a.port == b.port && (covers(of_a, of_b) || covers(of_b, of_a));
}

}  // namespace dwell::config
