// A bare Modbus client for the tests of the simulated rig: it sends what it is told, byte for byte, and hands back what
// came, so that a test sees the faults that a proper client would hide.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <chrono>
#include <cstdint>
#include <string>

#include "tests/rigsim/modbus_adu.hpp"
#include "tests/rigsim/sockets.hpp"
#include "tests/rigsim/stations.hpp"

namespace rigsim::test {

inline constexpr std::chrono::seconds kDeadline{20};  // generous: reached only by a failure

inline Fd connect_tcp(std::uint16_t port) {
  Fd fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) fd.close();
  return fd;
}

inline Fd open_serial(const std::string& path, speed_t speed = B115200) {
  Fd fd(::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  ::tcgetattr(fd.get(), &settings);
  ::cfmakeraw(&settings);
  ::cfsetspeed(&settings, speed);
  ::tcsetattr(fd.get(), TCSANOW, &settings);
  return fd;
}

inline void send_bytes(const Fd& fd, const Bytes& bytes) {
  [[maybe_unused]] const ssize_t size = ::write(fd.get(), bytes.data(), bytes.size());
}

// Up to `size` bytes; fewer when the other end closed, or within_s passed without any more.
inline Bytes receive_bytes(const Fd& fd, std::size_t size, double within_s = 20.0) {
  Bytes bytes;
  while (bytes.size() < size) {
    pollfd polled{fd.get(), POLLIN, 0};
    if (::poll(&polled, 1, static_cast<int>(within_s * 1e3)) <= 0) break;
    std::array<std::uint8_t, 512> chunk{};
    const ssize_t got = ::read(fd.get(), chunk.data(), std::min(chunk.size(), size - bytes.size()));
    if (got <= 0) break;
    bytes.insert(bytes.end(), chunk.begin(), chunk.begin() + got);
  }
  return bytes;
}

inline Bytes read_pdu(std::uint16_t address, std::uint16_t count, std::uint8_t function = 4) {
  return {function, static_cast<std::uint8_t>(address >> 8), static_cast<std::uint8_t>(address & 0xFF),
          static_cast<std::uint8_t>(count >> 8), static_cast<std::uint8_t>(count & 0xFF)};
}

// One TCP answer, header and all; empty: the connection is gone.
inline Bytes receive_tcp(const Fd& fd) {
  Bytes frame = receive_bytes(fd, 6);
  if (frame.size() < 6) return {};
  const Bytes rest = receive_bytes(fd, std::size_t{256} * frame[4] + frame[5]);
  frame.insert(frame.end(), rest.begin(), rest.end());
  return frame;
}

inline int transaction_of(const Bytes& frame) { return frame.size() < 2 ? -1 : frame[0] * 256 + frame[1]; }
// 0: no exception; -1: no answer.
inline int exception_of(const Bytes& frame) {
  if (frame.size() < 9) return -1;
  return (frame[7] & 0x80U) != 0 ? frame[8] : 0;
}

inline Bytes ask_tcp(const Fd& fd, int unit, const Bytes& pdu, std::uint16_t transaction = 1) {
  send_bytes(fd, tcp_frame(transaction, static_cast<std::uint8_t>(unit), pdu));
  return receive_tcp(fd);
}

// The value of a station's type from the bytes on the wire, written independently of the server's encoder: bytes are
// put into the order most significant first, then taken as a number.
inline double decode(const std::uint8_t* bytes, Station station) {
  const auto size = static_cast<std::size_t>(2 * station.words());
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t word = i / 2, byte = i % 2, last = size / 2 - 1;
    std::size_t from = i;
    if (station.order == Order::cdab) from = 2 * (last - word) + byte;
    if (station.order == Order::badc) from = 2 * word + (1 - byte);
    if (station.order == Order::dcba) from = size - 1 - i;
    bits = bits << 8 | bytes[from];
  }
  switch (station.type) {
    case Type::float32:
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    case Type::float64:
      return std::bit_cast<double>(bits);
    case Type::int32:
      return static_cast<std::int32_t>(bits);
    case Type::uint32:
      return static_cast<double>(bits);
    case Type::int16:
      return static_cast<std::int16_t>(bits);
    case Type::uint16:
      return static_cast<double>(bits);
  }
  return 0.0;
}

}  // namespace rigsim::test
