// clang-format off
#include <utility>
// clang-format on

#include "daemon/serve/modbus_server.hpp"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <unordered_set>

#include "daemon/serve/awaited_address.hpp"
#include "daemon/serve/listener.hpp"
#include "daemon/serve/tcp_listen.hpp"

namespace dwell {

namespace {
class ModbusClient;
}

struct ModbusServer::Impl : std::enable_shared_from_this<ModbusServer::Impl> {
  Impl(EventLoop& loop, ModbusOptions asked, ReadRegisters registers)
      : options(std::move(asked)), read(std::move(registers)), listener(loop) {}

  void welcome(boost::asio::ip::tcp::socket socket);
  bool make_room();

  const ModbusOptions options;
  const ReadRegisters read;
  Listener<boost::asio::ip::tcp> listener;
  AwaitedAddress address{options.host, false};
  std::unordered_set<ModbusClient*> clients;
  ModbusStats counts;  // clients apart: that is the set above
};

namespace {

class ModbusClient : public std::enable_shared_from_this<ModbusClient> {
 public:
  using Clock = std::chrono::steady_clock;

  ModbusClient(std::shared_ptr<ModbusServer::Impl> server, boost::asio::ip::tcp::socket socket)
      : server_(std::move(server)), socket_(std::move(socket)), timer_(socket_.get_executor()) {
    server_->clients.insert(this);
  }
  ~ModbusClient() { server_->clients.erase(this); }
  ModbusClient(const ModbusClient&) = delete;
  ModbusClient& operator=(const ModbusClient&) = delete;

  void begin() {
    limit(server_->options.idle_time);
    read();
  }

  void close() {
    server_->clients.erase(this);
    boost::system::error_code ignored;
    socket_.close(ignored);
    ++waits_;
    timer_.cancel();
  }

  [[nodiscard]] bool asked() const noexcept { return asked_; }
  [[nodiscard]] Clock::time_point silent_since() const noexcept { return silent_since_; }

 private:
  // Closes the connection unless limit() or rest() is called within this time. Asio cannot take back a handler that is
  // queued already, so the handler compares its number with the newest wait's.
  void limit(std::chrono::milliseconds time) {
    timer_.expires_after(time);
    timer_.async_wait([weak = weak_from_this(), number = ++waits_](const boost::system::error_code& error) {
      const auto self = weak.lock();
      if (error || !self || self->waits_ != number) return;
      ++self->server_->counts.timed_out;
      self->close();
    });
  }

  void read() {
    const auto room = conversation_.room();
    socket_.async_read_some(boost::asio::buffer(room.data(), room.size()),
                            [self = shared_from_this()](const boost::system::error_code& error, std::size_t count) {
                              if (error || !self->socket_.is_open()) return self->close();
                              self->received(count);
                            });
  }

  void received(std::size_t count) {
    // One limit holds for the whole request, so a client that sends byte by byte gains nothing.
    if (!conversation_.under_way()) limit(server_->options.request_time);
    switch (conversation_.received(count, server_->read)) {
      case ModbusConversation::Turn::more:
        return read();
      case ModbusConversation::Turn::answer:
        ++server_->counts.answers;
        return write();
      case ModbusConversation::Turn::refused:
        ++server_->counts.exceptions;
        return write();
      case ModbusConversation::Turn::broken:
        ++server_->counts.malformed;
        return close();
    }
  }

  void write() {
    asked_ = true;
    silent_since_ = Clock::now();
    limit(server_->options.request_time);
    const auto answer = conversation_.answer();
    boost::asio::async_write(socket_, boost::asio::buffer(answer.data(), answer.size()),
                             [self = shared_from_this()](const boost::system::error_code& error, std::size_t) {
                               if (error || !self->socket_.is_open()) return self->close();
                               self->rest();
                             });
  }

  void rest() {
    timer_.expires_after(server_->options.pause);
    ++waits_;  // the limit of the answer no longer counts
    timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
      if (!error && self->socket_.is_open()) self->begin();
    });
  }

  const std::shared_ptr<ModbusServer::Impl> server_;
  boost::asio::ip::tcp::socket socket_;
  boost::asio::steady_timer timer_;
  std::uint64_t waits_ = 0;  // number of the timer's newest wait
  ModbusConversation conversation_;
  bool asked_ = false;  // a whole request has come
  Clock::time_point silent_since_ = Clock::now();
};

}  // namespace

void ModbusServer::Impl::welcome(boost::asio::ip::tcp::socket socket) {
  if (clients.size() >= options.clients && !make_room()) {
    ++counts.refused;
    return;
  }
  boost::system::error_code ignored;
  socket.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
  std::make_shared<ModbusClient>(shared_from_this(), std::move(socket))->begin();
}

// Closes the connection that has been silent longest; those that never asked go first. False: all must be kept.
bool ModbusServer::Impl::make_room() {
  ModbusClient* longest = nullptr;
  const auto now = ModbusClient::Clock::now();
  const auto key = [](const ModbusClient* client) { return std::pair(client->asked(), client->silent_since()); };
  for (ModbusClient* client : clients) {
    if (client->asked() && now - client->silent_since() < options.kept_time) continue;
    if (longest == nullptr || key(client) < key(longest)) longest = client;
  }
  if (longest == nullptr) return false;
  longest->close();
  ++counts.displaced;
  return true;
}

tl::expected<std::unique_ptr<ModbusServer>, ListenFailure> ModbusServer::make(EventLoop& loop,
                                                                              const ModbusOptions& options,
                                                                              ReadRegisters read) {
  auto impl = std::make_shared<Impl>(loop, options, std::move(read));
  auto& acceptor = impl->listener.acceptor();
  const auto bound = bind_tcp(acceptor, options.host, options.port);
  if (!bound) return tl::unexpected(bound.error());
  impl->address = {options.host, *bound};
  boost::system::error_code error;
  // A pointer that does not own the server: it owns the listener, and each would keep the other alive.
  impl->listener.begin(
      [server = impl.get()](boost::asio::ip::tcp::socket socket) { server->welcome(std::move(socket)); }, error);
  if (error) return tl::unexpected(cannot_listen(options.host, options.port, error));
  return std::unique_ptr<ModbusServer>(new ModbusServer(std::move(impl)));
}

ModbusServer::ModbusServer(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

ModbusServer::~ModbusServer() {
  impl_->listener.close();
  const auto clients = impl_->clients;
  for (ModbusClient* client : clients) client->close();
}

std::uint16_t ModbusServer::port() const {
  boost::system::error_code ignored;
  return impl_->listener.acceptor().local_endpoint(ignored).port();
}

ModbusStats ModbusServer::stats() const noexcept {
  ModbusStats stats = impl_->counts;
  stats.clients = impl_->clients.size();
  stats.awaits_address = impl_->address.awaited();
  return stats;
}

}  // namespace dwell
