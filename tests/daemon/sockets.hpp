// What the tests of the servers share: a loop on a thread of its own, and blocking clients that give up after a while.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <future>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "daemon/serve/event_loop.hpp"

namespace dwell::test {

// Runs the loop until it is destroyed. Whatever belongs to the loop must be made before and destroyed after, or on it.
class LoopThread {
 public:
  explicit LoopThread(EventLoop& loop) : loop_(loop), thread_([&loop] { loop.run([](const char*) {}); }) {}
  ~LoopThread() {
    loop_.stop();
    thread_.join();
  }
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  // Runs `work` on the loop and hands back what it returns.
  template <class Work>
  auto on_loop(Work work) {
    std::packaged_task<decltype(work())()> task(std::move(work));
    auto result = task.get_future();
    loop_.post([&task] { task(); });
    return result.get();
  }

 private:
  EventLoop& loop_;
  std::thread thread_;
};

// A client that blocks, for 20 s at most.
class Client {
 public:
  static Client tcp(std::uint16_t port, int receive_buffer = 0) {
    Client client(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (receive_buffer > 0)
      setsockopt(client.descriptor_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    client.connect_to(reinterpret_cast<const sockaddr*>(&address), sizeof address);
    return client;
  }
  static Client local(const std::string& path) {
    Client client(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    client.connect_to(reinterpret_cast<const sockaddr*>(&address), sizeof address);
    return client;
  }
  Client(Client&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)),
        connected_(other.connected_),
        rest_(std::move(other.rest_)) {}
  Client& operator=(Client&&) = delete;
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  [[nodiscard]] bool connected() const { return connected_; }
  bool send(std::string_view text) const {
    while (!text.empty()) {
      const auto sent = ::send(descriptor_, text.data(), text.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  // Up to and including `mark`; what there was when the other end closed or time ran out.
  std::string until(std::string_view mark) {
    for (;;) {
      if (const auto found = rest_.find(mark); found != std::string::npos) {
        std::string text = rest_.substr(0, found + mark.size());
        rest_.erase(0, found + mark.size());
        return text;
      }
      if (!receive()) return std::exchange(rest_, {});
    }
  }
  std::string exactly(std::size_t size) {
    while (rest_.size() < size && receive()) {
    }
    std::string text = rest_.substr(0, size);
    rest_.erase(0, text.size());
    return text;
  }
  // Everything until the other end closes.
  std::string all() {
    while (receive()) {
    }
    return std::exchange(rest_, {});
  }

 private:
  explicit Client(int descriptor) : descriptor_(descriptor) {
    const timeval patience{20, 0};
    setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    setsockopt(descriptor_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  }
  void connect_to(const sockaddr* address, socklen_t size) { connected_ = connect(descriptor_, address, size) == 0; }
  bool receive() {
    char text[4096];
    const auto size = recv(descriptor_, text, sizeof text, 0);
    if (size <= 0) return false;
    rest_.append(text, static_cast<std::size_t>(size));
    return true;
  }

  int descriptor_;
  bool connected_ = false;
  std::string rest_;
};

struct Answer {
  int status = 0;
  std::string head;
  std::string body;
};

// Reads one response by its Content-Length; without a body for HEAD.
inline Answer read_answer(Client& client, bool head_only = false) {
  Answer answer;
  answer.head = client.until("\r\n\r\n");
  if (answer.head.size() > 12) answer.status = std::atoi(answer.head.c_str() + 9);
  const auto length = answer.head.find("Content-Length: ");
  if (!head_only && length != std::string::npos)
    answer.body = client.exactly(static_cast<std::size_t>(std::atol(answer.head.c_str() + length + 16)));
  return answer;
}

inline Answer get(std::uint16_t port, const std::string& target) {
  Client client = Client::tcp(port);
  client.send("GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  return read_answer(client);
}

}  // namespace dwell::test
