// A small HTTP/1.1 client for reading from the service: one GET per connection, and Server-Sent Events. Everything that
// the other side can make it spend is bounded: bytes of header, body and event, and time.
//
// Bound to one thread; blocks until the answer is there or the time has passed.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "daemon/ctl/stream_socket.hpp"

namespace dwell::ctl {

struct Url {
  std::string host;  // without the brackets of an IPv6 address
  std::string port = "80";
  std::string authority;  // HOST[:PORT] as given
  std::string prefix;     // path in front of the service's own, without a slash at its end
  std::string text;       // as given
  std::string token;      // sent as "Authorization: Bearer"; empty: none
};

// "http://HOST[:PORT][/PREFIX]". The error says what was expected.
[[nodiscard]] tl::expected<Url, std::string> parse_url(std::string_view text);

struct HttpLimits {
  std::chrono::milliseconds time{10'000};  // for the whole answer; of a stream, until its header is there
  std::size_t header_bytes = 16 * 1024;
  std::size_t body_bytes = 64 * 1024 * 1024;
  std::size_t event_bytes = 4 * 1024 * 1024;
};

struct HttpAnswer {
  int status = 0;
  std::string body;
};

// GET of prefix + path. Chunked answers are refused: the service sends none. The error names the address and the
// reason.
[[nodiscard]] tl::expected<HttpAnswer, std::string> http_get(const Url& url, std::string_view path,
                                                             const HttpLimits& limits = {});

// A stream of events, each a name and its data.
class EventStream {
 public:
  struct Event {
    std::string name;
    std::string data;
  };
  enum class Next : std::uint8_t { event, timeout, stopped, ended };

  static tl::expected<EventStream, std::string> open(const Url& url, std::string_view path,
                                                     const HttpLimits& limits = {});

  // Waits for the next whole event; `stopped` when stop_fd is readable. The error says why the stream cannot go on.
  [[nodiscard]] tl::expected<Next, std::string> next(Event& event, Deadline deadline, int stop_fd = -1);

 private:
  EventStream(StreamSocket socket, std::string received, std::size_t event_bytes);
  // Takes whole lines off the buffer; true once they have made up an event.
  bool take_lines(Event& event);

  StreamSocket socket_;
  std::string buffer_;        // received, not yet a whole line
  std::size_t searched_ = 0;  // of buffer_, where no line ends
  Event pending_;
  bool has_data_ = false;
  std::size_t event_bytes_;
};

}  // namespace dwell::ctl
