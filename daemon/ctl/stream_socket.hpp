// A client's stream socket, TCP or local, with a deadline on every call: whatever the other side does, the command
// ends. Bound to one thread, not real-time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace dwell::ctl {

using Deadline = std::chrono::steady_clock::time_point;

[[nodiscard]] Deadline in(std::chrono::milliseconds time);

class StreamSocket {
 public:
  // Every address of the host is tried until the deadline. The error is one line with the reason.
  static tl::expected<StreamSocket, std::string> connect_tcp(const std::string& host, const std::string& port,
                                                             Deadline deadline);
  static tl::expected<StreamSocket, std::string> connect_local(const std::string& path, Deadline deadline);

  ~StreamSocket();
  StreamSocket(StreamSocket&& other) noexcept;
  StreamSocket& operator=(StreamSocket&& other) noexcept;

  [[nodiscard]] tl::expected<void, std::string> send(std::string_view data, Deadline deadline);

  enum class Got : std::uint8_t { data, end, timeout, stopped };

  // Appends what has arrived, at most `most` bytes. stop_fd: its readability ends the wait (`stopped`); -1: none.
  [[nodiscard]] tl::expected<Got, std::string> receive(std::string& into, std::size_t most, Deadline deadline,
                                                       int stop_fd = -1);

 private:
  explicit StreamSocket(int fd) noexcept : fd_(fd) {}
  [[nodiscard]] tl::expected<void, std::string> finish_connect(int result, Deadline deadline);

  int fd_ = -1;  // owned, non-blocking
};

}  // namespace dwell::ctl
