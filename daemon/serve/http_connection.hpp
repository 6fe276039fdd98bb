// One client of the HTTP server. For http_server.cpp alone, the one translation unit that includes Beast. <utility>
// must come before this: Asio 1.74 needs it and does not include it.
#pragma once

#include <netinet/in.h>
#include <netinet/tcp.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <unordered_set>
#include <utility>

#include "daemon/serve/aside.hpp"
#include "daemon/serve/awaited_address.hpp"
#include "daemon/serve/downloads.hpp"
#include "daemon/serve/event_loop.hpp"
#include "daemon/serve/event_queue.hpp"
#include "daemon/serve/http_request.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/serve/listener.hpp"
#include "daemon/serve/next_part.hpp"

namespace dwell {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;
using boost::system::error_code;
using Event = EventQueue::Event;
using SteadyClock = std::chrono::steady_clock;

class HttpConnection;

struct HttpServer::Impl : std::enable_shared_from_this<HttpServer::Impl> {
  Impl(EventLoop& loop, HttpOptions asked, Handler answers, BeginStream begins)
      : options(std::move(asked)),
        handler(std::move(answers)),
        begin_stream(std::move(begins)),
        listener(loop),
        downloads(loop, options.downloads),
        aside(loop, "earlier") {}

  void welcome(tcp::socket socket);
  bool make_room();
  // As one event that all streams share for which wanted(stream) holds.
  template <class Wanted>
  void send(std::string text, bool yields, Wanted wanted);

  const HttpOptions options;
  const Handler handler;
  const BeginStream begin_stream;
  Listener<tcp> listener;
  Downloads downloads;
  Aside aside;  // makes the answers that wait for the disk
  std::unordered_set<HttpConnection*> connections;
  std::unordered_set<HttpConnection*> streams;
  AwaitedAddress address{options.host, false};
  std::size_t large_bytes = 0;  // of large answers on their way
  std::size_t made_aside = 0;   // answers that are being made
  HttpStats counts;             // clients and streams apart: those are the sets above
};

// An IPv4 client of an IPv6 socket as what it is.
inline asio::ip::address unmapped(const asio::ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
}

// One client: requests one after the other, or from a request for the stream on, events.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(std::shared_ptr<HttpServer::Impl> server, tcp::socket socket)
      : server_(std::move(server)), stream_(std::move(socket)), waiting_(server_->options.events_waiting) {
    error_code ignored;
    const asio::ip::address from = unmapped(stream_.socket().remote_endpoint(ignored).address());
    from_ = from.to_string();
    from_loopback_ = from.is_loopback();
    server_->connections.insert(this);
  }
  ~HttpConnection() { forget(); }
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  // Awaits a request. One deadline holds for the whole request, so a client that sends byte by byte gains nothing.
  void read() {
    phase_ = Phase::asking;
    silent_since_ = SteadyClock::now();
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(server_->options.header_bytes));
    parser_->body_limit(server_->options.body_bytes);
    stream_.expires_after(server_->options.request_time);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](const error_code& error, std::size_t) {
      self->or_close([&] { self->received(error); });
    });
  }

  // yields: the event waits behind those that do not yield, and is dropped before them.
  void push(const Event& event, bool yields) {
    // Asio ran out of memory and dropped the write, perhaps with half an event sent.
    if (writing_ && written_by_.expired()) return leave();
    if (!waiting_.push(event, yields)) ++server_->counts.events_dropped;
    if (!writing_) write_event();
  }

  void close() {
    forget();
    stream_.close();
  }

  // Since when it could have asked for something and has not; nullopt: it keeps its place.
  [[nodiscard]] std::optional<SteadyClock::time_point> silent_since() const {
    const bool kept = phase_ == Phase::answered || (phase_ == Phase::asking && served_ &&
                                                    SteadyClock::now() - silent_since_ < server_->options.kept_time);
    if (kept) return std::nullopt;
    return silent_since_;
  }
  [[nodiscard]] std::string_view holder() const noexcept { return holder_; }
  // Whether the query of this stream names the event.
  [[nodiscard]] bool asks_for(std::string_view name) const noexcept {
    for (std::string_view rest = stream_query_; !rest.empty();)
      if (next_part(rest, '&') == name) return true;
    return false;
  }
  [[nodiscard]] bool served() const { return served_ && phase_ == Phase::asking; }

 private:
  static constexpr const char* kEventStream = "text/event-stream";
  enum class Phase : std::uint8_t { asking, answered, leaving };

  // Does a step. Where memory runs out in it, the connection is closed: nothing would be under way any more.
  template <class Step>
  void or_close(Step step) {
    try {
      step();
    } catch (const std::exception&) {
      leave();
    }
  }

  void forget() {
    server_->connections.erase(this);
    server_->streams.erase(this);
  }

  void received(const error_code& error) {
    if (!stream_.socket().is_open()) return;  // closed meanwhile: the handler may be gone
    if (error == http::error::end_of_stream) return shut();
    if (error == http::error::header_limit)
      return answer(http_error(431, "the header fields are too large"), false, false);
    if (error == http::error::body_limit) return answer(http_error(413, "the body is too large"), false, false);
    if (error.category() == http::make_error_code(http::error::bad_method).category())
      return answer(http_error(400, "not a request: " + error.message()), false, false);
    if (error) return;  // gone, or out of time: nothing can be answered
    ++server_->counts.requests;
    const bool keep_alive = parser_->get().keep_alive();
    const HttpRequest request = asked();
    const bool head = request.method == HttpRequest::Method::head;
    if (auto refused = refusal(request, server_->options.names))
      return answer(std::move(refused->reply), head, !refused->ends && keep_alive);
    const bool stream = request.path() == server_->options.stream_path;
    if (stream && request.method != HttpRequest::Method::post) return begin_stream(request, head, keep_alive);
    HttpReply reply;
    try {
      reply = unless_known(server_->handler(request), request);
    } catch (const std::exception&) {
      reply = http_error(500, "the answer could not be made");
    }
    if (reply.later) return answer_later(std::move(reply.later), head, keep_alive);
    if (reply.awaited) return answer_once_told(reply.awaited, head, keep_alive);
    if (reply.file.empty()) return answer(std::move(reply), head, keep_alive);
    begin_file(std::move(reply), head, keep_alive);
  }

  // The request that has been read; its views point into the parser's bytes.
  [[nodiscard]] HttpRequest asked() const {
    const auto& read = parser_->get();
    const auto field = [&read](http::field name) {
      const auto value = read[name];
      return std::string_view(value.data(), value.size());
    };
    HttpRequest request;
    request.method = read.method() == http::verb::get    ? HttpRequest::Method::get
                     : read.method() == http::verb::head ? HttpRequest::Method::head
                     : read.method() == http::verb::post ? HttpRequest::Method::post
                                                         : HttpRequest::Method::other;
    request.host_needed = read.version() >= 11;
    request.hosts = read.count(http::field::host);
    request.host = field(http::field::host);
    request.target = {read.target().data(), read.target().size()};
    request.known = field(http::field::if_none_match);
    request.authorization = field(http::field::authorization);
    request.content_type = field(http::field::content_type);
    request.cookie = field(http::field::cookie);
    request.origin = field(http::field::origin);
    request.encodings = field(http::field::accept_encoding);
    request.codings = read.count(http::field::transfer_encoding);
    request.coding = field(http::field::transfer_encoding);
    request.has_length = read.count(http::field::content_length) > 0;
    request.body = read.body();
    request.from = from_;
    request.from_loopback = from_loopback_;
    return request;
  }

  template <class Body>
  void set_fields(http::response<Body>& response, const HttpReply& reply) const {
    response.set(http::field::server, server_->options.server);
    response.set(http::field::content_type, reply.content_type);
    response.set(http::field::cache_control, reply.tag.empty() ? "no-store" : "no-cache");
    if (!reply.tag.empty()) response.set(http::field::etag, reply.tag);
    if (!reply.encoding.empty()) response.set(http::field::content_encoding, reply.encoding);
    if (reply.varies) response.set(http::field::vary, "Accept-Encoding");
    if (!reply.policy.empty()) response.set("Content-Security-Policy", reply.policy);
    response.set("X-Content-Type-Options", "nosniff");
    if (!reply.cookie.empty()) response.set(http::field::set_cookie, reply.cookie);
    if (!reply.allowed.empty()) response.set(http::field::allow, reply.allowed);
    if (response.result() == http::status::unauthorized) response.set(http::field::www_authenticate, "Bearer");
  }

  void answer(HttpReply reply, bool head, bool keep_alive) {
    phase_ = Phase::answered;
    std::shared_ptr<void> share;
    if (const std::size_t size = reply.body.size(); size > server_->options.large_bytes) {
      if (server_->large_bytes + size > server_->options.answers_bytes) {
        reply = http_error(503, "too many large answers are on their way; try again, or ask for less at once");
      } else {
        server_->large_bytes += size;
        share = std::shared_ptr<void>(nullptr, [server = server_, size](void*) { server->large_bytes -= size; });
      }
    }
    // The status line says HTTP/1.1 to a client of 1.0 too (RFC 9110, 2.5). The connection stays or ends as it asked.
    auto response = std::make_shared<http::response<http::string_body>>();
    response->result(static_cast<unsigned>(reply.status));
    set_fields(*response, reply);
    response->keep_alive(keep_alive);
    if (reply.status != 304) response->content_length(reply.body.size());
    if (!head) response->body() = std::move(reply.body);
    stream_.expires_after(server_->options.request_time);
    http::async_write(stream_, *response,
                      [self = shared_from_this(), response, share](const error_code& error, std::size_t) {
                        if (error) return;
                        self->served_ = true;
                        self->or_close([&] { response->keep_alive() ? self->read() : self->shut(); });
                      });
  }

  void answer_later(std::function<HttpReply()> make, bool head, bool keep_alive) {
    phase_ = Phase::answered;
    if (server_->made_aside >= server_->options.downloads)
      return answer(http_error(503, "too many runs are being read; try again"), head, keep_alive);
    ++server_->made_aside;
    const auto place = std::shared_ptr<void>(nullptr, [server = server_](void*) { --server->made_aside; });
    stream_.expires_never();  // the disk has no deadline
    server_->aside.ask(
        [make = std::move(make)]() -> HttpReply {
          try {
            return make();
          } catch (const std::exception&) {
            return http_error(500, "the answer could not be made");
          }
        },
        [self = shared_from_this(), place, head, keep_alive](HttpReply reply) {
          self->or_close([&] { self->answer(std::move(reply), head, keep_alive); });
        });
  }

  void answer_once_told(const std::function<void(HttpReply::Tell)>& awaited, bool head, bool keep_alive) {
    phase_ = Phase::answered;
    stream_.expires_never();  // whoever tells sets the time
    awaited([self = shared_from_this(), head, keep_alive](HttpReply reply) {
      self->or_close([&] { self->answer(std::move(reply), head, keep_alive); });
    });
  }

  void begin_file(HttpReply reply, bool head_alone, bool keep_alive) {
    phase_ = Phase::answered;
    const std::string path = reply.file;
    const auto self = shared_from_this();
    server_->downloads.begin(path, head_alone,
                             {stream_, server_->options.request_time,
                              [self, reply = std::move(reply), keep_alive](std::uint64_t bytes) {
                                return self->head_of_file(reply, bytes, keep_alive);
                              },
                              [self, head_alone, keep_alive](HttpReply refusal) {
                                self->answer(std::move(refusal), head_alone, keep_alive);
                              },
                              [self, keep_alive] {
                                self->served_ = true;
                                keep_alive ? self->read() : self->shut();
                              },
                              [self] { self->leave(); }});
  }

  [[nodiscard]] std::string head_of_file(const HttpReply& reply, std::uint64_t bytes, bool keep_alive) const {
    http::response<http::empty_body> response(http::status::ok, 11);
    set_fields(response, reply);
    response.set(http::field::content_disposition, "attachment; filename=\"" + reply.file_name + "\"");
    response.keep_alive(keep_alive);
    response.content_length(bytes);
    std::ostringstream head;
    head.exceptions(std::ios::badbit);  // as in begin_stream()
    head << response.base();
    return head.str();
  }

  // Says that nothing more comes, then reads for up to a second what the client still sends. Closing with bytes unread
  // would reset the connection, and the client might never see the answer.
  void shut() {
    phase_ = Phase::leaving;
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.expires_after(std::min(server_->options.request_time, std::chrono::milliseconds(1000)));
    swallow();
  }
  void swallow() {
    stream_.async_read_some(asio::buffer(ignored_), [self = shared_from_this()](const error_code& error, std::size_t) {
      if (!error) self->or_close([&] { self->swallow(); });
    });
  }

  void begin_stream(const HttpRequest& request, bool head_alone, bool keep_alive) {
    auto begun = server_->streams.size() < server_->options.streams
                     ? server_->begin_stream(request)
                     : tl::unexpected(http_error(503, "too many live streams"));
    if (!begun) return answer(std::move(begun.error()), head_alone, keep_alive);
    if (head_alone) return answer({200, {}, kEventStream}, true, keep_alive);
    phase_ = Phase::answered;
    stream_query_ = request.query();
    holder_ = std::move(begun->holder);
    server_->streams.insert(this);
    bound_unsent();
    http::response<http::empty_body> response(http::status::ok, 11);
    set_fields(response, {200, {}, kEventStream});
    response.keep_alive(false);
    std::ostringstream head;
    head.exceptions(std::ios::badbit);  // without it, a lack of memory would cut the head short in silence
    head << response.base() << "retry: 1000\n\n";
    stream_.expires_never();
    swallow_stream();
    push(std::make_shared<const std::string>(head.str() + begun->first_event), false);
  }

  // Bounds the bytes that the kernel has taken and not yet sent. An event that the kernel has taken can no longer be
  // dropped or overtaken. Its own bound is 4 MB: minutes of traces in front of the newest dwell. Larger: a slow reader
  // sees the dwell later. Smaller: more turns of the event loop for a large event.
  void bound_unsent() {
    constexpr int kUnsent = 32 * 1024;
    setsockopt(stream_.socket().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsent, sizeof kUnsent);
  }

  // A stream's client has nothing to say; reading tells when it has gone.
  void swallow_stream() {
    stream_.async_read_some(asio::buffer(ignored_), [self = shared_from_this()](const error_code& error, std::size_t) {
      if (error) return self->leave();
      self->or_close([&] { self->swallow_stream(); });
    });
  }

  void write_event() {
    const Event event = waiting_.take();
    writing_ = event != nullptr;
    if (!writing_) return;
    const auto token = std::make_shared<char>();
    written_by_ = token;
    stream_.expires_after(server_->options.stream_write_time);  // of the write; the pending read never expires
    asio::async_write(stream_, asio::buffer(*event),
                      [self = shared_from_this(), event, token](const error_code& error, std::size_t) {
                        if (error || !self->writing_) return self->leave();  // it may have left already
                        self->or_close([&] { self->write_event(); });
                      });
  }

  void leave() {
    writing_ = false;
    waiting_.clear();
    close();
  }

  const std::shared_ptr<HttpServer::Impl> server_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::string stream_query_, holder_;  // of a stream
  EventQueue waiting_;
  bool writing_ = false;            // an event is being written …
  std::weak_ptr<void> written_by_;  // … unless this has expired: then Asio has dropped the write
  std::array<char, 1024> ignored_{};
  std::string from_;  // its numeric address
  bool from_loopback_ = false;
  bool served_ = false;  // it has been given an answer
  Phase phase_ = Phase::asking;
  SteadyClock::time_point silent_since_ = SteadyClock::now();
};

}  // namespace dwell
