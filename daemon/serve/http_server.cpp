// The one translation unit that includes Beast. <utility> comes first: Asio 1.74 needs it and does not include it.
// clang-format off
#include <utility>
// clang-format on

#include "daemon/serve/http_server.hpp"

#include "daemon/serve/http_connection.hpp"
#include "daemon/serve/tcp_listen.hpp"

namespace dwell {

std::string event_text(std::string_view name, std::string_view data) {
  std::string text;
  text.reserve(name.size() + data.size() + 16);
  text.append("event: ").append(name).append("\ndata: ").append(data).append("\n\n");
  return text;
}

// Closes the connection that has been silent longest; those that were never served go first. False: none may be closed.
bool HttpServer::Impl::make_room() {
  HttpConnection* longest = nullptr;
  for (HttpConnection* connection : connections) {
    if (!connection->silent_since()) continue;
    const auto key = [](const HttpConnection* c) { return std::pair(c->served(), *c->silent_since()); };
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
      std::make_shared<HttpConnection>(shared_from_this(), std::move(socket))->read();
    } catch (const std::exception&) {
      ++counts.refused;
    }
    return;
  }
  ++counts.refused;
  // Says why, if the kernel takes it at once.
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

tl::expected<std::unique_ptr<HttpServer>, ListenFailure> HttpServer::make(EventLoop& loop, const HttpOptions& options,
                                                                          Handler handler, BeginStream begin_stream) {
  auto impl = std::make_shared<Impl>(loop, options, std::move(handler), std::move(begin_stream));
  const auto bound = bind_tcp(impl->listener.acceptor(), options.host, options.port);
  if (!bound) return tl::unexpected(bound.error());
  impl->address = {options.host, *bound};
  error_code error;
  // A pointer that does not own the server: it owns the listener, and each would keep the other alive.
  impl->listener.begin([server = impl.get()](tcp::socket socket) { server->welcome(std::move(socket)); }, error);
  if (error) return tl::unexpected(cannot_listen(options.host, options.port, error));
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

HttpServer::HttpServer(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

HttpServer::~HttpServer() {
  impl_->listener.close();
  impl_->downloads.close();  // a callback that waits for a piece would keep the server alive …
  impl_->aside.close();      // … as would one that waits for an answer
  const auto connections = impl_->connections;
  for (HttpConnection* connection : connections) connection->close();
}

std::uint16_t HttpServer::port() const {
  error_code ignored;
  return impl_->listener.acceptor().local_endpoint(ignored).port();
}

template <class Wanted>
void HttpServer::Impl::send(std::string text, bool yields, Wanted wanted) {
  if (streams.empty()) return;
  const auto event = std::make_shared<const std::string>(std::move(text));
  const auto all = streams;
  for (HttpConnection* stream : all) {
    if (!wanted(*stream)) continue;
    try {
      stream->push(event, yields);
    } catch (const std::exception&) {
      stream->close();  // out of memory; the others are not to suffer
    }
  }
}

void HttpServer::end_streams() {
  const auto streams = impl_->streams;
  for (HttpConnection* stream : streams) stream->close();
}

void HttpServer::end_streams(std::string_view holder) {
  const auto streams = impl_->streams;
  for (HttpConnection* stream : streams)
    if (stream->holder() == holder) stream->close();
}

void HttpServer::broadcast(std::string_view name, std::string_view data) {
  impl_->send(event_text(name, data), false, [](const HttpConnection&) { return true; });
}

void HttpServer::broadcast_to_askers(std::string_view name, std::string_view data) {
  impl_->send(event_text(name, data), true, [name](const HttpConnection& stream) { return stream.asks_for(name); });
}

bool HttpServer::asked_for(std::string_view name) const noexcept {
  return std::any_of(impl_->streams.begin(), impl_->streams.end(),
                     [name](const HttpConnection* stream) { return stream->asks_for(name); });
}

HttpStats HttpServer::stats() const noexcept {
  HttpStats stats = impl_->counts;
  stats.clients = impl_->connections.size();
  stats.streams = impl_->streams.size();
  stats.awaits_address = impl_->address.awaited();
  return stats;
}

}  // namespace dwell
