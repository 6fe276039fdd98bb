#include "tests/ctl/scripted_server.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <stdexcept>

namespace dwell::test {

ScriptedServer::ScriptedServer(std::vector<Reply> replies, const std::string& path)
    : replies_(std::move(replies)), local_(!path.empty()) {
  sockaddr_storage storage{};
  socklen_t size = 0;
  if (local_) {
    auto& address = reinterpret_cast<sockaddr_un&>(storage);
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    size = sizeof address;
  } else {
    auto& address = reinterpret_cast<sockaddr_in&>(storage);
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    size = sizeof address;
  }
  listener_ = ::socket(local_ ? AF_UNIX : AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  auto* const address = reinterpret_cast<sockaddr*>(&storage);
  if (::bind(listener_, address, size) != 0 || ::listen(listener_, 8) != 0 || ::pipe(stop_) != 0) {
    throw std::runtime_error("the scripted server cannot listen");
  }
  if (!local_) {
    ::getsockname(listener_, address, &size);
    port_ = ntohs(reinterpret_cast<sockaddr_in&>(storage).sin_port);
  }
  thread_ = std::thread([this] { serve(); });
}

ScriptedServer::~ScriptedServer() {
  ::close(stop_[1]);
  thread_.join();
  cut();
  ::close(stop_[0]);
  ::close(listener_);
}

std::string ScriptedServer::url() const { return "http://127.0.0.1:" + std::to_string(port_); }

std::vector<std::string> ScriptedServer::requests() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return requests_;
}

void ScriptedServer::cut() {
  for (const int client : beside_) ::close(client);
  beside_.clear();
}

void ScriptedServer::serve() {
  for (std::size_t i = 0;; ++i) {
    std::array<pollfd, 2> fds{{{listener_, POLLIN, 0}, {stop_[0], POLLIN, 0}}};
    ::poll(fds.data(), fds.size(), -1);
    if (fds[1].revents != 0) return;
    const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    if (i < replies_.size() && replies_[i].cuts) cut();
    if (i < replies_.size()) answer(client, replies_[i]);
    if (i < replies_.size() && replies_[i].beside) {
      beside_.push_back(client);
    } else {
      ::close(client);
    }
  }
}

void ScriptedServer::answer(int client, const Reply& reply) {
  std::string request;
  std::array<char, 4096> buffer{};
  const std::string end = local_ ? "\n" : "\r\n\r\n";
  while (request.find(end) == std::string::npos) {
    const ssize_t got = ::recv(client, buffer.data(), buffer.size(), 0);
    if (got <= 0) return;
    request.append(buffer.data(), static_cast<std::size_t>(got));
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requests_.push_back(request.substr(0, request.find(end)));
  }
  ::send(client, reply.text.data(), reply.text.size(), MSG_NOSIGNAL);
  while (reply.hold || reply.trickle) {
    std::array<pollfd, 2> fds{{{client, POLLIN, 0}, {stop_[0], POLLIN, 0}}};
    ::poll(fds.data(), fds.size(), reply.trickle ? 1 : -1);
    if (fds[1].revents != 0) return;
    if (fds[0].revents != 0 && ::recv(client, buffer.data(), buffer.size(), 0) <= 0) return;
    if (reply.trickle && ::send(client, "x", 1, MSG_NOSIGNAL) != 1) return;
  }
}

std::string http_reply(int status, const std::string& body) {
  return "HTTP/1.1 " + std::to_string(status) +
         " Whatever\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
         "\r\nConnection: close\r\n\r\n" + body;
}

std::string stream_header() {
  return "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\n\r\nretry: 1000\n\n";
}

std::string dwell_event(const std::string& data) { return "event: dwell\ndata: " + data + "\n\n"; }

}  // namespace dwell::test
