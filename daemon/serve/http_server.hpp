// The HTTP server: HTTP/1.1, one listening address, on the event loop; Server-Sent Events for live push.
//
// It knows nothing of what it serves: a handler answers paths, broadcast() pushes events. Everything a client can make
// it spend is bounded: clients, streams among them, header and body, the time for a request, the events waiting for one
// slow reader (those that must be asked for are dropped first, then the oldest; all are counted). Where there are as
// many clients as there may be, a new one takes the place of the one that has been silent longest: of those that never
// asked for anything first, then of those that have asked, after `kept_time`. Who is being answered or reads a stream
// keeps its place. Bound to the event loop's thread.
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
  std::string
      tag{};  // names the bytes, with quotes (ETag): a client that has them is answered 304; empty: news each time
  std::string policy{};   // Content-Security-Policy; empty: none
  std::string allowed{};  // of 405: the methods that the path knows
  std::string cookie{};   // Set-Cookie; empty: none
};

struct HttpOptions {
  std::string host = "127.0.0.1";  // a numeric address, or "localhost"
  std::uint16_t port = 8380;       // 0: the kernel chooses
  std::string server = "dwelld";   // Server field
  std::string stream_path = "/api/v1/stream";
  std::vector<std::string> names;          // by which clients may ask for it beside numeric addresses and "localhost"
  std::size_t clients = 128;               // connections at once; more are answered 503 where nobody can make room
  std::size_t streams = 96;                // of which live streams; the rest stays free for requests
  std::size_t header_bytes = 8 * 1024;     // beyond: 431
  std::size_t body_bytes = 16 * 1024;      // beyond: 413
  std::size_t large_bytes = 1'000'000;     // an answer beyond this is large …
  std::size_t answers_bytes = 64'000'000;  // … and all large ones on their way together hold this at most; beyond: 503
  std::size_t events_waiting = 16;         // per stream, behind the one on its way
  std::chrono::milliseconds request_time{
      10'000};  // from its first chance to be sent until it is here, and for the answer
  // A client that has been answered keeps its place for so long at least. Shorter: pages that poll connect anew each
  // time while somebody holds every place; longer: so long such clients can keep others out.
  std::chrono::milliseconds kept_time{2'000};
  std::chrono::milliseconds stream_write_time{30'000};  // for one event; then the reader is given up
};

struct HttpStats {
  std::uint64_t clients = 0;  // now
  std::uint64_t streams = 0;  // now
  std::uint64_t requests = 0;
  std::uint64_t refused = 0;         // connections, because there were too many
  std::uint64_t displaced = 0;       // silent connections that made room for new ones
  std::uint64_t events_dropped = 0;  // because a reader was slow
  bool awaits_address = false;       // the address is not there yet: nobody can be served
};

// What a live stream begins with.
struct StreamBegin {
  std::string first_event;  // as event_text makes it; empty: none yet
  std::string holder{};     // whose stream it is, for end_streams(holder); empty: nobody's
};

class HttpServer {
 public:
  // Answers GET, HEAD (the server leaves the body out) and POST of a path.
  using Handler = std::function<HttpReply(const HttpRequest& request)>;
  // Or why this client gets no stream. Asked for HEAD as well, which gets the head of the answer alone.
  using BeginStream = std::function<tl::expected<StreamBegin, HttpReply>(const HttpRequest& request)>;

  // Binds and listens. An address that this computer does not have yet (a cable or a lease comes later than the
  // service) is bound all the same and is served once it is there.
  static tl::expected<std::unique_ptr<HttpServer>, ListenFailure> make(EventLoop& loop, const HttpOptions& options,
                                                                 Handler handler, BeginStream begin_stream);
  ~HttpServer();  // closes every connection
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  // Ends every stream, or those of one holder. Whoever may still read connects again.
  void end_streams();
  void end_streams(std::string_view holder);
  // Sends `data` (one line) as an event of this name to every stream.
  void broadcast(std::string_view name, std::string_view data);
  // The same to those streams alone that asked for it in their query, as in /api/v1/stream?NAME&NAME. Such an event
  // yields to those that every stream gets.
  void broadcast_to_askers(std::string_view name, std::string_view data);
  // Whether any stream did.
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
