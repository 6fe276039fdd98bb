// The HTTP server: HTTP/1.1, one listening address, on the event loop; Server-Sent Events for live push.
//
// A handler answers paths, broadcast() pushes events; the server does not know what they mean. Limits bound the number
// of clients, of streams and of files under way, header and body, the time for a request, and the events that wait for
// a slow reader. Of each file under way two pieces are in memory.
// Waiting events beyond the limit are dropped and counted: first those that a client must ask for, then the oldest.
//
// When all places are taken, a new client replaces the one that has been silent longest. Clients that never asked for
// anything go first, then those whose last answer is older than `kept_time`. A client that is being answered or reads a
// stream keeps its place. Bound to the event loop's thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "daemon/serve/listen_failure.hpp"

namespace dwell {

class EventLoop;
struct HttpRequest;

struct HttpReply {
  int status = 200;
  std::string body;
  std::string content_type = "application/json";
  // ETag, with its quotes: names the bytes. A client that holds them is answered 304. Empty: the answer is never
  // stored.
  std::string tag{};
  std::string policy{};    // Content-Security-Policy; empty: none
  std::string allowed{};   // Allow, of 405: the methods that the path answers
  std::string cookie{};    // Set-Cookie; empty: none
  std::string encoding{};  // Content-Encoding; empty: none
  bool varies = false;     // Vary: the answer depends on Accept-Encoding
  // Path of a file that is the body, streamed piece by piece. Empty: `body` is.
  std::string file{};
  std::string file_name{};  // under which a browser keeps it: letters, digits, ".", "_" and "-"
  // Makes the answer aside: for what waits for the disk. Owns what it uses. Empty: this is the answer.
  std::function<HttpReply()> later{};
  // Has the answer told once, on the loop's thread: for what is known only later. If nobody tells, the client waits
  // until it gives up. Empty: this is the answer.
  using Tell = std::function<void(HttpReply)>;
  std::function<void(Tell)> awaited{};
};

struct HttpOptions {
  std::string host = "127.0.0.1";  // a numeric address, or "localhost"
  std::uint16_t port = 8380;       // 0: the kernel chooses
  std::string server = "dwelld";   // Server field
  std::string stream_path = "/api/v1/stream";
  std::vector<std::string> names;          // of this service in a Host field, beside numeric addresses and "localhost"
  std::size_t clients = 128;               // connections at once; more are answered 503 where nobody can make room
  std::size_t streams = 96;                // live streams among them; the other places stay free for requests
  std::size_t header_bytes = 8 * 1024;     // beyond: 431
  std::size_t body_bytes = 16 * 1024;      // beyond: 413
  std::size_t large_bytes = 1'000'000;     // an answer beyond this is large …
  std::size_t answers_bytes = 64'000'000;  // … and all large answers under way hold this at most; beyond: 503
  std::size_t downloads = 4;               // files under way at once; beyond: 503. As many answers that are made aside
  std::size_t events_waiting = 16;         // per stream, behind the one that is being written
  // For a request, from when it could be sent until it has been read; the same again for taking the answer, or each
  // piece of 128 kB of a file: who reads a download at less than 13 kB/s loses its place among them.
  std::chrono::milliseconds request_time{10'000};
  // A client that was answered keeps its place for so long. Shorter: while somebody holds all places, pages that poll
  // connect anew each time. Longer: for so long, clients that ask once can keep others out.
  std::chrono::milliseconds kept_time{2'000};
  // For taking one event; then the connection is closed.
  std::chrono::milliseconds stream_write_time{30'000};
};

struct HttpStats {
  std::uint64_t clients = 0;  // now
  std::uint64_t streams = 0;  // now
  std::uint64_t requests = 0;
  std::uint64_t refused = 0;         // connections, because there were too many
  std::uint64_t displaced = 0;       // silent connections that made room for new ones
  std::uint64_t events_dropped = 0;  // because a reader was slow
  bool awaits_address = false;       // this computer does not have the address yet: nobody can be served
};

// What a live stream begins with.
struct StreamBegin {
  std::string first_event;  // as event_text makes it; empty: none yet
  std::string holder{};     // for end_streams(holder): whose stream it is; empty: nobody's
};

class HttpServer {
 public:
  // Answers GET, HEAD (the server leaves the body out) and POST of a path.
  using Handler = std::function<HttpReply(const HttpRequest& request)>;
  // How a client's stream begins, or why it gets none. Called for HEAD too, which is answered without a body.
  using BeginStream = std::function<tl::expected<StreamBegin, HttpReply>(const HttpRequest& request)>;

  // Binds and listens. An address that this computer does not have yet is bound all the same, and is served once it has
  // it: a cable or a lease may come later than the service.
  static tl::expected<std::unique_ptr<HttpServer>, ListenFailure> make(EventLoop& loop, const HttpOptions& options,
                                                                       Handler handler, BeginStream begin_stream);
  ~HttpServer();  // closes every connection
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  // Ends every stream, or those of one holder. A client that may still read connects again.
  void end_streams();
  void end_streams(std::string_view holder);
  // Sends `data` (one line) as an event of this name to every stream.
  void broadcast(std::string_view name, std::string_view data);
  // The same, but only to streams whose query names the event, as in /api/v1/stream?NAME&NAME. Such an event waits
  // behind those of broadcast() and is dropped before them.
  void broadcast_to_askers(std::string_view name, std::string_view data);
  // Whether a stream's query names the event.
  [[nodiscard]] bool asked_for(std::string_view name) const noexcept;

  [[nodiscard]] HttpStats stats() const noexcept;

  struct Impl;  // defined where Beast is

 private:
  explicit HttpServer(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

// An event as it travels. `data` is one line.
[[nodiscard]] std::string event_text(std::string_view name, std::string_view data);

// {"error": reason, "status": status}
[[nodiscard]] HttpReply http_error(int status, std::string_view reason);

}  // namespace dwell
