#include "daemon/ctl/control_client.hpp"

#include "daemon/ctl/stream_socket.hpp"

namespace dwell::ctl {
namespace {

tl::expected<std::string, std::string> exchange(const std::string& path, std::string_view line,
                                                const ControlLimits& limits) {
  const Deadline deadline = in(limits.time);
  auto socket = StreamSocket::connect_local(path, deadline);
  if (!socket) return tl::unexpected(socket.error());
  if (const auto sent = socket->send(std::string(line) + "\n", deadline); !sent) return tl::unexpected(sent.error());
  std::string received;
  std::size_t searched = 0;
  while (true) {
    const auto end = received.find('\n', searched);
    if (end != std::string::npos) return received.substr(0, end);
    searched = received.size();
    if (received.size() >= limits.line_bytes) return tl::unexpected(std::string("the answer is too long"));
    const auto got = socket->receive(received, limits.line_bytes - received.size(), deadline);
    if (!got) return tl::unexpected(got.error());
    if (*got == StreamSocket::Got::timeout) return tl::unexpected(std::string("no answer in time"));
    if (*got == StreamSocket::Got::end)
      return tl::unexpected(std::string("the connection was closed before an answer"));
  }
}

}  // namespace

tl::expected<std::string, std::string> control_exchange(const std::string& path, std::string_view line,
                                                        const ControlLimits& limits) {
  auto answer = exchange(path, line, limits);
  if (!answer) return tl::unexpected(path + ": " + answer.error());
  return answer;
}

}  // namespace dwell::ctl
