// Binds an acceptor to an address of the rig file. For whoever speaks Asio; <utility> must come before this.
#pragma once

#include <netinet/in.h>

#include <boost/asio/ip/tcp.hpp>
#include <cerrno>
#include <cstdint>
#include <string>
#include <tl/expected.hpp>

#include "daemon/serve/listen_failure.hpp"

namespace dwell {

[[nodiscard]] inline ListenFailure cannot_listen(const std::string& host, std::uint16_t port,
                                                 const boost::system::error_code& error) {
  return {false, "cannot listen on " + host + ":" + std::to_string(port) + ": " + error.message()};
}

// host: a numeric address or "localhost"; port 0: the kernel chooses. Returns true if this computer does not have the
// address yet. Then the socket is bound all the same (IP_FREEBIND, ip(7)) and clients are served once it has it;
// AwaitedAddress says when.
[[nodiscard]] inline tl::expected<bool, ListenFailure> bind_tcp(boost::asio::ip::tcp::acceptor& acceptor,
                                                                const std::string& host, std::uint16_t port) {
  using boost::asio::ip::tcp;
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(host == "localhost" ? "127.0.0.1" : host, error);
  if (error) return tl::unexpected(ListenFailure{true, "listen: \"" + host + "\" is no numeric address"});
  const tcp::endpoint endpoint(address, port);
  bool awaits = false;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (error.value() == EADDRNOTAVAIL) {
    const int yes = 1;
    const bool v6 = address.is_v6();
    awaits = setsockopt(acceptor.native_handle(), v6 ? IPPROTO_IPV6 : IPPROTO_IP, v6 ? IPV6_FREEBIND : IP_FREEBIND,
                        &yes, sizeof yes) == 0;
    if (awaits) acceptor.bind(endpoint, error);
  }
  if (error) return tl::unexpected(cannot_listen(host, port, error));
  return awaits;
}

}  // namespace dwell
