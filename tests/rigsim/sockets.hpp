// The descriptors the server needs, each made in one call: a descriptor that closes itself, listeners, a
// pseudo-terminal.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace rigsim {

template <typename T>
using Result = tl::expected<T, std::string>;

// Owns a descriptor.
class Fd {
 public:
  Fd() = default;
  explicit Fd(int fd) noexcept : fd_(fd) {}
  Fd(Fd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Fd& operator=(Fd&& other) noexcept {
    if (this != &other) {
      close();
      fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
  }
  ~Fd() { close(); }

  [[nodiscard]] int get() const noexcept { return fd_; }
  explicit operator bool() const noexcept { return fd_ >= 0; }
  void close() noexcept;

 private:
  int fd_ = -1;
};

// All of these are non-blocking and close on exec.
[[nodiscard]] Result<Fd> listen_tcp(const std::string& host, std::uint16_t port);
[[nodiscard]] Result<Fd> listen_unix(const std::string& path);
[[nodiscard]] std::uint16_t bound_port(const Fd& listener);
[[nodiscard]] Fd accept_from(const Fd& listener, bool tcp);

// Closes a TCP connection with RST instead of FIN.
void reset_connection(Fd& connection);

// A pseudo-terminal pair in raw mode. The slave stays open here, so that the master lives on between clients.
struct PseudoTerminal {
  Fd master, slave;
  std::string path;  // of the slave
};
[[nodiscard]] Result<PseudoTerminal> open_pseudo_terminal();

// The wire it stands for: bits per second and per character.
struct Line {
  double baud = 115200;
  int bits = 11;
};
// Speed and stop bits as the client has set them; a pseudo-terminal does not keep the client's parity, so that is told.
[[nodiscard]] Line line_settings(const PseudoTerminal& terminal, bool parity);

}  // namespace rigsim
