// A server that answers each connection by a script, for tests of clients: it says what it was told to say, byte for
// byte, in pieces if asked, and then closes or holds the connection open.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace dwell::test {

struct Reply {
  std::string text;
  bool hold = false;     // keep the connection until the client or the test ends it
  bool trickle = false;  // afterwards send one byte after the other for ever
  bool beside = false;   // keep the connection until the test ends, and answer the next ones meanwhile
  bool cuts = false;     // first end the connections that are kept so
};

class ScriptedServer {
 public:
  // Connection i is answered by replies[i]; further ones are closed at once. path empty: TCP on a port of the kernel's
  // choice; else a local socket.
  explicit ScriptedServer(std::vector<Reply> replies, const std::string& path = "");
  ~ScriptedServer();
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;

  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }
  [[nodiscard]] std::string url() const;
  // What the clients have sent, up to their first empty line or line end (local).
  [[nodiscard]] std::vector<std::string> requests();

 private:
  void serve();
  void cut();
  void answer(int client, const Reply& reply);

  const std::vector<Reply> replies_;
  std::vector<int> beside_;  // connections that are kept
  const bool local_;
  int listener_ = -1;
  int stop_[2] = {-1, -1};  // a pipe; readable once this is to end
  std::uint16_t port_ = 0;
  std::mutex mutex_;
  std::vector<std::string> requests_;  // guarded by mutex_
  std::thread thread_;
};

// An HTTP answer with its length.
[[nodiscard]] std::string http_reply(int status, const std::string& body);
// The header of an event stream, and one event.
[[nodiscard]] std::string stream_header();
[[nodiscard]] std::string dwell_event(const std::string& data);

}  // namespace dwell::test
