#include "daemon/ctl/stream_socket.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>

namespace dwell::ctl {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

// Waits until `fd` is ready for `events`. 1 ready, 0 timeout, 2 stop_fd is readable, negative: -errno.
int wait(int fd, short events, Deadline deadline, int stop_fd) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    std::array<pollfd, 2> fds{{{fd, events, 0}, {stop_fd, POLLIN, 0}}};
    const int timeout_ms = static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 3'600'000));
    const int ready = ::poll(fds.data(), fds.size(), timeout_ms);  // a negative descriptor is ignored
    if (ready < 0 && errno != EINTR) return -errno;
    if (ready < 0) continue;
    if (fds[1].revents != 0) return 2;
    if (fds[0].revents != 0) return 1;
    if (left.count() <= 0) return 0;
  }
}

// A peer that vanished without a word is noticed within about 20 s even on a stream that only receives.
void detect_dead_peer(int fd) {
  const auto set = [fd](int level, int option, int value) { ::setsockopt(fd, level, option, &value, sizeof value); };
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 5);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 5);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
}

}  // namespace

Deadline in(std::chrono::milliseconds time) { return std::chrono::steady_clock::now() + time; }

StreamSocket::~StreamSocket() {
  if (fd_ >= 0) ::close(fd_);
}
StreamSocket::StreamSocket(StreamSocket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
StreamSocket& StreamSocket::operator=(StreamSocket&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

tl::expected<void, std::string> StreamSocket::finish_connect(int result, Deadline deadline) {
  if (result == 0) return {};
  if (errno != EINPROGRESS) return tl::unexpected(reason(errno));
  const int ready = wait(fd_, POLLOUT, deadline, -1);
  if (ready < 0) return tl::unexpected(reason(-ready));
  if (ready == 0) return tl::unexpected(std::string("no answer in time"));
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &size);
  if (error != 0) return tl::unexpected(reason(error));
  return {};
}

tl::expected<StreamSocket, std::string> StreamSocket::connect_tcp(const std::string& host, const std::string& port,
                                                                  Deadline deadline) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int code = ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (code != 0) return tl::unexpected(std::string(::gai_strerror(code)));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, &::freeaddrinfo);
  std::string why = "no address";
  for (const addrinfo* a = found; a != nullptr; a = a->ai_next) {
    StreamSocket socket(::socket(a->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol));
    if (socket.fd_ < 0) {
      why = reason(errno);
      continue;
    }
    const auto connected = socket.finish_connect(::connect(socket.fd_, a->ai_addr, a->ai_addrlen), deadline);
    if (connected) {
      detect_dead_peer(socket.fd_);
      return socket;
    }
    why = connected.error();
  }
  return tl::unexpected(why);
}

tl::expected<StreamSocket, std::string> StreamSocket::connect_local(const std::string& path, Deadline deadline) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return tl::unexpected(std::string("the path is too long for a socket"));
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  StreamSocket socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (socket.fd_ < 0) return tl::unexpected(reason(errno));
  const int result = ::connect(socket.fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (const auto connected = socket.finish_connect(result, deadline); !connected) {
    return tl::unexpected(connected.error());
  }
  return socket;
}

tl::expected<void, std::string> StreamSocket::send(std::string_view data, Deadline deadline) {
  while (!data.empty()) {
    if (std::chrono::steady_clock::now() >= deadline)
      return tl::unexpected(std::string("the request was not taken in time"));
    const ssize_t sent = ::send(fd_, data.data(), data.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      data.remove_prefix(static_cast<std::size_t>(sent));
      continue;
    }
    if (errno != EAGAIN && errno != EINTR) return tl::unexpected(reason(errno));
    const int ready = wait(fd_, POLLOUT, deadline, -1);
    if (ready < 0) return tl::unexpected(reason(-ready));
  }
  return {};
}

tl::expected<StreamSocket::Got, std::string> StreamSocket::receive(std::string& into, std::size_t most,
                                                                   Deadline deadline, int stop_fd) {
  std::array<char, 16384> buffer;
  while (true) {
    // Also where something is always there to be read: a trickle must not keep the command for ever.
    if (std::chrono::steady_clock::now() >= deadline) return Got::timeout;
    const int ready = wait(fd_, POLLIN, deadline, stop_fd);
    if (ready < 0) return tl::unexpected(reason(-ready));
    if (ready == 0) return Got::timeout;
    if (ready == 2) return Got::stopped;
    const ssize_t got = ::recv(fd_, buffer.data(), std::min(most, buffer.size()), 0);
    if (got > 0) {
      into.append(buffer.data(), static_cast<std::size_t>(got));
      return Got::data;
    }
    if (got == 0) return Got::end;
    if (errno != EAGAIN && errno != EINTR) return tl::unexpected(reason(errno));
  }
}

}  // namespace dwell::ctl
