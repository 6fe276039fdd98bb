// An address to listen on, as the rig file has it. Pure, thread-safe.
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

// "ADDRESS:PORT" with an IPv4 address, an IPv6 address in brackets or localhost; nothing: it is none.
[[nodiscard]] std::optional<ListenAddress> split_address(const std::string& text);

// Whether the host names many computers, multicast or broadcast: nobody can connect to it.
[[nodiscard]] bool is_for_many(const std::string& host);

// Whether only one of the two can be listened on: the same port, and a host that is or covers the other. "0.0.0.0"
// covers all of IPv4 and "[::]" everything.
[[nodiscard]] bool collide(const ListenAddress& a, const ListenAddress& b);

}  // namespace dwell::config
