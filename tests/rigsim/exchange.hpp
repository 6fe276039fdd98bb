// The Modbus side of the server: connections and the pseudo-terminal, requests out of the bytes received, answers sent
// when they are due. Non-blocking; the server's loop tells it which descriptors are ready.
#pragma once

#include <poll.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tests/rigsim/responder.hpp"
#include "tests/rigsim/simulated_clock.hpp"

namespace rigsim {

// Bound to one thread. Everything it keeps is bounded: connections, answers awaiting their time, unread bytes.
class Exchange {
 public:
  // clock: the host's, as the simulated time is counted from; both outlive this.
  Exchange(Responder& responder, const std::function<std::int64_t()>& clock, const SimulatedClock& time);

  void add_terminal(PseudoTerminal terminal, bool parity);
  void accept_connection(const Fd& listener);
  void close_connections();
  void reset_connections();
  [[nodiscard]] std::size_t connection_count() const;

  // Appends one entry per link, to be handed back to serve() after the wait.
  void watch(std::vector<pollfd>& polled) const;
  // Sends what is due, reads what has come. Connections must not have been added or removed since watch().
  void serve(std::span<const pollfd> polled);
  // When (CLOCK_MONOTONIC) serve() is next needed without anything having come; none: never.
  [[nodiscard]] std::optional<std::int64_t> next_due_ns() const;
  // Forgets links that have closed.
  void sweep();

 private:
  struct Link {
    std::uint64_t id;
    Fd connection;  // TCP
    Bytes in;
    bool busy = false;  // a request is being answered; what follows waits
    std::int64_t last_received_ns = 0;
  };
  struct Pending {
    std::uint64_t link;
    Request request;
    Fate fate;
    double t_s;  // simulated: when it is sampled
    std::int64_t sample_ns, send_ns;
    bool sampled;
    Bytes frame;
    [[nodiscard]] std::int64_t due_ns() const { return sampled ? send_ns : sample_ns; }
  };

  [[nodiscard]] int descriptor(const Link& link) const;
  [[nodiscard]] Link* find(std::uint64_t id);
  void receive(Link& link);
  void process(Link& link);
  void handle(Link& link, const Request& request);
  void transmit(Link& link, const Bytes& frame);
  void run_due();

  Responder& responder_;
  const std::function<std::int64_t()>& clock_;
  const SimulatedClock& time_;
  PseudoTerminal terminal_;
  bool parity_ = true;
  std::vector<Link> links_;
  std::vector<Pending> pending_;
  std::uint64_t next_id_ = 1;
};

}  // namespace rigsim
