#include "tests/rigsim/sockets.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace rigsim {
namespace {

tl::unexpected<std::string> failed(const std::string& what) {
  return tl::make_unexpected(what + ": " + std::strerror(errno));
}

}  // namespace

void Fd::close() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

Result<Fd> listen_tcp(const std::string& host, std::uint16_t port) {
  const std::string name = "cannot listen on " + host + ":" + std::to_string(port);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  if (inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1)
    return tl::make_unexpected(name + ": expected an IPv4 address");
  Fd fd(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!fd) return failed(name);
  const int on = 1;
  ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || ::listen(fd.get(), 64) != 0)
    return failed(name);
  return fd;
}

Result<Fd> listen_unix(const std::string& path) {
  const std::string name = "cannot listen on " + path;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return tl::make_unexpected(name + ": the path is too long");
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  Fd fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!fd) return failed(name);
  // A socket left by an earlier run is in the way; anything else is not ours to remove.
  struct stat what {};
  if (::lstat(path.c_str(), &what) == 0 && S_ISSOCK(what.st_mode)) ::unlink(path.c_str());
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || ::listen(fd.get(), 8) != 0)
    return failed(name);
  return fd;
}

std::uint16_t bound_port(const Fd& listener) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.sin_port);
}

Fd accept_from(const Fd& listener, bool tcp) {
  Fd fd(::accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (fd && tcp) {
    const int on = 1;
    ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }
  return fd;
}

void reset_connection(Fd& connection) {
  const linger at_once{1, 0};
  ::setsockopt(connection.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  connection.close();
}

Result<PseudoTerminal> open_pseudo_terminal() {
  PseudoTerminal out;
  out.master = Fd(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (!out.master || ::grantpt(out.master.get()) != 0 || ::unlockpt(out.master.get()) != 0)
    return failed("cannot make a pseudo-terminal");
  std::array<char, 128> name{};
  if (::ptsname_r(out.master.get(), name.data(), name.size()) != 0) return failed("cannot name the pseudo-terminal");
  out.path = name.data();
  out.slave = Fd(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (!out.slave) return failed("cannot open " + out.path);
  termios settings{};
  if (::tcgetattr(out.slave.get(), &settings) != 0) return failed("cannot set up " + out.path);
  ::cfmakeraw(&settings);
  ::cfsetspeed(&settings, B115200);
  ::tcsetattr(out.slave.get(), TCSANOW, &settings);
  ::fcntl(out.master.get(), F_SETFL, O_NONBLOCK);
  return out;
}

Line line_settings(const PseudoTerminal& terminal, bool parity) {
  Line line;
  termios settings{};
  if (::tcgetattr(terminal.slave.get(), &settings) != 0) return line;
  struct Speed {
    speed_t code;
    double baud;
  };
  static constexpr Speed kSpeeds[] = {{B1200, 1200},     {B2400, 2400},     {B4800, 4800},     {B9600, 9600},
                                      {B19200, 19200},   {B38400, 38400},   {B57600, 57600},   {B115200, 115200},
                                      {B230400, 230400}, {B460800, 460800}, {B921600, 921600}, {B1000000, 1000000}};
  const speed_t code = ::cfgetospeed(&settings);
  for (const Speed& speed : kSpeeds)
    if (speed.code == code) line.baud = speed.baud;
  // Start, eight data bits, stop, and one more: parity or a second stop bit.
  line.bits = parity || (settings.c_cflag & CSTOPB) != 0 ? 11 : 10;
  return line;
}

}  // namespace rigsim
