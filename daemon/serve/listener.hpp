// A listening socket that goes on accepting whatever befalls: where memory or descriptors have run out it tries again
// a quarter of a second later. For whoever speaks Asio; <utility> must come before this.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/socket_base.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <utility>

#include "daemon/serve/event_loop.hpp"

namespace dwell {

// Bound to the event loop's thread.
template <class Protocol>
class Listener {
 public:
  using Socket = typename Protocol::socket;
  using Acceptor = typename Protocol::acceptor;
  // Takes the next client. What it throws costs that client its connection and nobody else anything.
  using Welcome = std::function<void(Socket)>;

  explicit Listener(EventLoop& loop) : loop_(loop), state_(std::make_shared<State>(loop.context())) {}
  ~Listener() { close(); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  // To be opened and bound before begin().
  [[nodiscard]] Acceptor& acceptor() noexcept { return state_->acceptor; }

  // Nobody is accepted any more.
  void close() noexcept {
    boost::system::error_code ignored;
    state_->acceptor.close(ignored);
  }

  // Listens, and welcomes one client after the other until close().
  void begin(Welcome welcome, boost::system::error_code& error) {
    state_->acceptor.listen(boost::asio::socket_base::max_listen_connections, error);
    if (error) return;
    state_->welcome = std::move(welcome);
    State::accept(state_);
    loop_.every(std::chrono::milliseconds(250), [weak = std::weak_ptr(state_)] {
      if (const auto state = weak.lock(); state && state->accepting.expired() && state->acceptor.is_open())
        State::accept(state);
    });
  }

 private:
  // What an accept under way holds on to.
  struct State {
    explicit State(boost::asio::io_context& context) : acceptor(context) {}

    static void accept(const std::shared_ptr<State>& self) {
      // Where memory ends within Asio the handler is never called; that it is gone is then all there is to see.
      const auto waiting = std::make_shared<char>();
      self->accepting = waiting;
      self->acceptor.async_accept([self, waiting](const boost::system::error_code& error, Socket socket) {
        // Out of descriptors, perhaps: trying again at once would turn the loop into a busy one.
        if (error || !self->acceptor.is_open()) return;
        try {
          self->welcome(std::move(socket));
        } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): the client sees its connection closed
        }
        accept(self);
      });
    }

    Acceptor acceptor;
    Welcome welcome;
    std::weak_ptr<void> accepting;  // expired: nobody waits for the next client
  };

  EventLoop& loop_;
  std::shared_ptr<State> state_;
};

}  // namespace dwell
