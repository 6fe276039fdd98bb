// The CAN side of the server: the transducers as nodes that send their message each at its own instants, and what can
// befall a bus. Non-blocking; the server's loop tells it when it has something to do.
#pragma once

#include <poll.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/rigsim/bus_trouble.hpp"
#include "tests/rigsim/can_wire.hpp"
#include "tests/rigsim/responder.hpp"
#include "tests/rigsim/simulated_clock.hpp"

namespace rigsim {

// Bound to one thread. All but a late frame is sampled at the instant at which it is sent.
class CanNodes {
 public:
  CanNodes(const Options& options, Responder& responder, const std::function<std::int64_t()>& clock,
           const SimulatedClock& time);

  Result<void> open();

  void watch(std::vector<pollfd>& polled) const;
  // When (CLOCK_MONOTONIC) serve() is next needed; none: never.
  [[nodiscard]] std::optional<std::int64_t> next_due_ns() const;
  // Sends what is due, reads what has come.
  void serve(std::int64_t now_ns);

  // "bus-off", "restart", "error-passive", "can on|off". None: the verb is another's.
  [[nodiscard]] std::optional<std::string> command(const std::vector<std::string>& words);
  // Members of a JSON object.
  [[nodiscard]] std::string status() const;
  void set_drift(double ppm) noexcept { drift_ppm_ = ppm; }

 private:
  struct Pending {
    std::int64_t due_ns;
    WireFrame frame;
  };

  [[nodiscard]] bool active() const noexcept { return wire_ && !trouble_.off() && !responder_.silent; }
  [[nodiscard]] bool happens(double probability);
  [[nodiscard]] double period_ns() const noexcept;
  void sample(std::size_t channel, std::int64_t now_ns);
  void send(const WireFrame& frame);

  std::string interface_;
  double rate_hz_;
  double drift_ppm_;
  Responder& responder_;
  const std::function<std::int64_t()>& clock_;
  const SimulatedClock& time_;
  std::optional<CanWire> wire_;
  std::vector<std::int64_t> next_ns_;  // CLOCK_MONOTONIC, of each channel's next frame
  std::vector<std::uint16_t> counters_;
  std::vector<double> values_;
  std::vector<Pending> pending_;
  std::vector<WireFrame> received_;
  BusTrouble trouble_;
  std::int64_t silent_until_ns_ = 0;
  std::uint64_t sent_ = 0, lost_ = 0, late_ = 0, refused_ = 0;
  std::mt19937_64 random_;
};

}  // namespace rigsim
