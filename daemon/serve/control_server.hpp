// The control socket: a local stream socket whose file permissions say who may change something. One JSON object per
// line in, one per line out. On the event loop; bounded in clients, in line length and in time.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace dwell {

class EventLoop;

struct ControlOptions {
  std::string path;
  std::size_t clients = 16;            // at once; more take the place of one that has not asked anything, or are closed
  std::size_t line_bytes = 64 * 1024;  // beyond: an error, and the connection ends
  std::chrono::milliseconds idle_time{60'000};  // without a whole line, or with an answer not taken
};

// Who asks, by the kernel's word.
struct Peer {
  uid_t uid = static_cast<uid_t>(-1);
  pid_t pid = -1;
};

// The handler's reply to a line: the answer, or a function that gets a callback to answer later.
struct ControlReply {
  // To be called once, on the loop's thread, even after the connection or the server has gone. If it is not called, the
  // caller waits until it gives up.
  using Answer = std::function<void(std::string line)>;

  ControlReply(std::string line) : now(std::move(line)) {}
  explicit ControlReply(std::function<void(Answer)> work) : later(std::move(work)) {}

  std::string now;
  std::function<void(Answer)> later;
};

class ControlServer {
 public:
  // One line in, without its end, to one line out, without its end. A caller's next line waits for the answer.
  using Handler = std::function<ControlReply(std::string_view line, const Peer& peer)>;

  // Binds (mode 0660) and listens. A socket that a dead process left behind is replaced; one that answers is not.
  static tl::expected<std::unique_ptr<ControlServer>, std::string> make(EventLoop& loop, const ControlOptions& options,
                                                                        Handler handler);
  ~ControlServer();  // closes every connection and removes the socket
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  struct Impl;  // defined where Asio is

 private:
  explicit ControlServer(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace dwell
