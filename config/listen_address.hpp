// An address to listen on, as the rig file gives it. Pure, thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace dwell::config {

struct ListenAddress {
  std::string text;        // as given, for instance "[::1]:8380"
  std::string host;        // without the brackets of an IPv6 address
  std::uint16_t port = 0;  // 0: any free one
};

// Parses "ADDRESS:PORT" with an IPv4 address, an IPv6 address in brackets or localhost. nullopt: another form.
[[nodiscard]] std::optional<ListenAddress> split_address(const std::string& text);

// The functions below take the host of a ListenAddress.

// Nobody can connect to such an address.
[[nodiscard]] bool is_multicast_or_broadcast(const std::string& host);

// Whether other computers can reach the address. ::ffff:127.0.0.1 counts as beyond.
[[nodiscard]] bool beyond_loopback(const std::string& host);

// Whether two servers cannot listen on both: the port is the same, and the hosts are the same or one covers the other.
// "0.0.0.0" covers all of IPv4, "[::]" everything.
[[nodiscard]] bool collide(const ListenAddress& a, const ListenAddress& b);

}  // namespace dwell::config
