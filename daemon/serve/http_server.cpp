// The one translation unit that includes Beast. <utility> comes first: Asio 1.74 needs it and does not include it.
// clang-format off
#include <utility>
// clang-format on

#include "daemon/serve/http_server.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <deque>
#include <optional>
#include <sstream>
#include <unordered_set>

#include "daemon/serve/event_loop.hpp"
#include "daemon/serve/http_request.hpp"
#include "daemon/serve/listener.hpp"
#include "daemon/serve/tcp_listen.hpp"

namespace dwell {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;
using boost::system::error_code;
using Event = std::shared_ptr<const std::string>;
using SteadyClock = std::chrono::steady_clock;

namespace {
class Connection;
}

struct HttpServer::Impl : std::enable_shared_from_this<HttpServer::Impl> {
  Impl(EventLoop& loop, HttpOptions asked, Handler answers, FirstEvent first)
      : options(std::move(asked)), handler(std::move(answers)), first_event(std::move(first)), listener(loop) {}

  void welcome(tcp::socket socket);
  bool make_room();
  // As one event that all streams share for which wanted(stream) holds.
  template <class Wanted>
  void send(std::string text, Wanted wanted);

  const HttpOptions options;
  const Handler handler;
  const FirstEvent first_event;
  Listener<tcp> listener;
  std::unordered_set<Connection*> connections;
  std::unordered_set<Connection*> streams;
  bool awaits_address = false;
  std::size_t large_bytes = 0;  // of large answers on their way
  HttpStats counts;             // clients and streams apart: those are the sets above
};

namespace {

// An IPv4 client of an IPv6 socket as what it is.
asio::ip::address unmapped(const asio::ip::address& address) {
  if (!address.is_v6() || !address.to_v6().is_v4_mapped()) return address;
  return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
}

// One client: requests one after the other, or from a request for the stream on, events.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(std::shared_ptr<HttpServer::Impl> server, tcp::socket socket)
      : server_(std::move(server)), stream_(std::move(socket)) {
    error_code ignored;
    const asio::ip::address from = unmapped(stream_.socket().remote_endpoint(ignored).address());
    from_ = from.to_string();
    from_loopback_ = from.is_loopback();
    server_->connections.insert(this);
  }
  ~Connection() { forget(); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Awaits a request. The deadline is one for all of it, so a client that sends byte by byte gains nothing.
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

  void push(const Event& event) {
    const bool idle = waiting_.empty();
    if (!idle && writing_.expired()) return leave();  // its memory ended within Asio, perhaps halfway through an event
    if (waiting_.size() >= server_->options.events_waiting) {
      // The first one is on its way out; the oldest behind it goes.
      waiting_.erase(waiting_.begin() + 1);
      ++server_->counts.events_dropped;
    }
    waiting_.push_back(event);
    if (idle) write_event();
  }

  void close() {
    forget();
    stream_.close();
  }

  // Since when it has had its chance to ask and has not; nullopt: it keeps its place.
  [[nodiscard]] std::optional<SteadyClock::time_point> silent_since() const {
    const bool kept = phase_ == Phase::answered || (phase_ == Phase::asking && served_ &&
                                                    SteadyClock::now() - silent_since_ < server_->options.kept_time);
    if (kept) return std::nullopt;
    return silent_since_;
  }
  // Whether the query of this stream names the event.
  [[nodiscard]] bool asks_for(std::string_view name) const noexcept {
    for (std::string_view rest = stream_query_; !rest.empty();) {
      const std::string_view term = rest.substr(0, rest.find('&'));
      if (term == name) return true;
      rest.remove_prefix(std::min(term.size() + 1, rest.size()));
    }
    return false;
  }
  [[nodiscard]] bool served() const { return served_ && phase_ == Phase::asking; }

 private:
  enum class Phase : std::uint8_t { asking, answered, leaving };

  // Does it; a connection for which there is no memory is closed, rather than left with nothing under way.
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
    if (error == http::error::end_of_stream) return shut();
    if (error == http::error::header_limit)
      return answer(http_error(431, "the header fields are too large"), false, false);
    if (error == http::error::body_limit) return answer(http_error(413, "the body is too large"), false, false);
    if (error.category() == http::make_error_code(http::error::bad_method).category())
      return answer(http_error(400, "not a request: " + error.message()), false, false);
    if (error) return;  // gone, or out of time: what it wanted is not known
    ++server_->counts.requests;
    const bool keep_alive = parser_->get().keep_alive();
    const HttpRequest request = asked();
    const bool head = request.method == HttpRequest::Method::head;
    if (auto refused = refusal(request, server_->options.names))
      return answer(std::move(refused->reply), head, !refused->ends && keep_alive);
    const bool stream = request.path() == server_->options.stream_path;
    if (stream && request.method == HttpRequest::Method::get) return begin_stream(request, keep_alive);
    HttpReply reply;
    if (stream && head) {
      reply.content_type = "text/event-stream";
    } else {
      try {
        reply = unless_known(server_->handler(request), request);
      } catch (const std::exception&) {
        reply = http_error(500, "the answer could not be made");
      }
    }
    answer(std::move(reply), head, keep_alive);
  }

  // What has been read; the views are of the parser's own bytes.
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
    // HTTP/1.1 in the status line even where 1.0 was asked, as RFC 9110 has it; the connection is as the client wants.
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

  // Says that nothing more comes, then waits a little for what the client still sends: closing on unread bytes would
  // reset the connection, and the answer might never be seen.
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

  void begin_stream(const HttpRequest& request, bool keep_alive) {
    auto first = server_->streams.size() < server_->options.streams
                     ? server_->first_event(request)
                     : tl::unexpected(http_error(503, "too many live streams"));
    if (!first) return answer(std::move(first.error()), false, keep_alive);
    phase_ = Phase::answered;
    stream_query_ = request.query();
    server_->streams.insert(this);
    http::response<http::empty_body> response(http::status::ok, 11);
    set_fields(response, {200, {}, "text/event-stream"});
    response.keep_alive(false);
    std::ostringstream head;
    head.exceptions(std::ios::badbit);  // or what memory does not suffice for is left out
    head << response.base() << "retry: 1000\n\n";
    stream_.expires_never();
    swallow_stream();
    push(std::make_shared<const std::string>(head.str() + *first));
  }

  // Nothing is expected from a stream's client; reading tells when it has gone.
  void swallow_stream() {
    stream_.async_read_some(asio::buffer(ignored_), [self = shared_from_this()](const error_code& error, std::size_t) {
      if (error) return self->leave();
      self->or_close([&] { self->swallow_stream(); });
    });
  }

  void write_event() {
    if (waiting_.empty()) return;
    const auto token = std::make_shared<char>();
    writing_ = token;
    stream_.expires_after(server_->options.stream_write_time);  // the pending read keeps its own: never
    asio::async_write(
        stream_, asio::buffer(*waiting_.front()),
        [self = shared_from_this(), event = waiting_.front(), token](const error_code& error, std::size_t) {
          if (error || self->waiting_.empty()) return self->leave();  // empty: it has left already
          self->waiting_.pop_front();
          self->or_close([&] { self->write_event(); });
        });
  }

  void leave() {
    waiting_.clear();
    close();
  }

  const std::shared_ptr<HttpServer::Impl> server_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::string stream_query_;     // of a stream: its query
  std::deque<Event> waiting_;    // the first one is being written
  std::weak_ptr<void> writing_;  // expired: nothing is
  std::array<char, 1024> ignored_{};
  std::string from_;  // its numeric address
  bool from_loopback_ = false;
  bool served_ = false;  // it has been given an answer
  Phase phase_ = Phase::asking;
  SteadyClock::time_point silent_since_ = SteadyClock::now();
};

}  // namespace

std::string event_text(std::string_view name, std::string_view data) {
  std::string text;
  text.reserve(name.size() + data.size() + 16);
  text.append("event: ").append(name).append("\ndata: ").append(data).append("\n\n");
  return text;
}

// Closes the connection that has been silent longest, one that was never served before one that was; false: there is
// none.
bool HttpServer::Impl::make_room() {
  Connection* longest = nullptr;
  for (Connection* connection : connections) {
    if (!connection->silent_since()) continue;
    const auto key = [](const Connection* c) { return std::pair(c->served(), *c->silent_since()); };
    if (longest == nullptr || key(connection) < key(longest)) longest = connection;
  }
  if (longest == nullptr) return false;
  longest->close();
  ++counts.displaced;
  return true;
}

void HttpServer::Impl::welcome(tcp::socket socket) {
  if (connections.size() < options.clients || make_room()) {
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    try {
      std::make_shared<Connection>(shared_from_this(), std::move(socket))->read();
    } catch (const std::exception&) {
      ++counts.refused;
    }
    return;
  }
  ++counts.refused;
  // A word of explanation if it can be had for nothing.
  const std::string body = http_error(503, "too many clients").body;
  const std::string text =
      "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/json\r\nConnection: close\r\n"
      "Content-Length: " +
      std::to_string(body.size()) + "\r\n\r\n" + body;
  error_code ignored;
  socket.non_blocking(true, ignored);
  socket.write_some(asio::buffer(text), ignored);
  socket.shutdown(tcp::socket::shutdown_send, ignored);
}

tl::expected<std::unique_ptr<HttpServer>, HttpServer::Failure> HttpServer::make(EventLoop& loop,
                                                                                const HttpOptions& options,
                                                                                Handler handler,
                                                                                FirstEvent first_event) {
  auto impl = std::make_shared<Impl>(loop, options, std::move(handler), std::move(first_event));
  const auto bound = bind_tcp(impl->listener.acceptor(), options.host, options.port);
  if (!bound) return tl::unexpected(bound.error());
  impl->awaits_address = *bound;
  error_code error;
  // Not the server itself: a listener that holds on to it would keep it for ever.
  impl->listener.begin([server = impl.get()](tcp::socket socket) { server->welcome(std::move(socket)); }, error);
  if (error) return tl::unexpected(cannot_listen(options.host, options.port, error));
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

HttpServer::HttpServer(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

HttpServer::~HttpServer() {
  impl_->listener.close();
  const auto connections = impl_->connections;
  for (Connection* connection : connections) connection->close();
}

std::uint16_t HttpServer::port() const {
  error_code ignored;
  return impl_->listener.acceptor().local_endpoint(ignored).port();
}

bool HttpServer::awaits_address() const noexcept { return impl_->awaits_address; }

template <class Wanted>
void HttpServer::Impl::send(std::string text, Wanted wanted) {
  if (streams.empty()) return;
  const auto event = std::make_shared<const std::string>(std::move(text));
  const auto all = streams;
  for (Connection* stream : all) {
    if (!wanted(*stream)) continue;
    try {
      stream->push(event);
    } catch (const std::exception&) {
      stream->close();  // out of memory; the others are not to suffer
    }
  }
}

void HttpServer::end_streams() {
  const auto streams = impl_->streams;
  for (Connection* stream : streams) stream->close();
}

void HttpServer::broadcast(std::string_view name, std::string_view data) {
  impl_->send(event_text(name, data), [](const Connection&) { return true; });
}

void HttpServer::broadcast_to_askers(std::string_view name, std::string_view data) {
  impl_->send(event_text(name, data), [name](const Connection& stream) { return stream.asks_for(name); });
}

bool HttpServer::asked_for(std::string_view name) const noexcept {
  return std::any_of(impl_->streams.begin(), impl_->streams.end(),
                     [name](const Connection* stream) { return stream->asks_for(name); });
}

HttpStats HttpServer::stats() const noexcept {
  HttpStats stats = impl_->counts;
  stats.clients = impl_->connections.size();
  stats.streams = impl_->streams.size();
  return stats;
}

}  // namespace dwell
