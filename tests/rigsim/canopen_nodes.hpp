// The CANopen side of the server: every channel of the rig a node of its own on one bus, sampled when a SYNC comes, and
// what can befall such a bus. Non-blocking; the server's loop tells it when it has something to do.
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
#include "tests/rigsim/canopen_node.hpp"
#include "tests/rigsim/responder.hpp"
#include "tests/rigsim/simulated_clock.hpp"

namespace rigsim {

inline constexpr int kMostCanopenMasses = 125;

// Bound to one thread. Node i + 1 is channel i as Device counts.
class CanopenNodes {
 public:
  CanopenNodes(const Options& options, Responder& responder, const std::function<std::int64_t()>& clock,
               const SimulatedClock& time);
  CanopenNodes(const CanopenNodes&) = delete;
  CanopenNodes& operator=(const CanopenNodes&) = delete;

  Result<void> open();

  void watch(std::vector<pollfd>& polled) const;
  // When (CLOCK_MONOTONIC) serve() is next needed; none: never.
  [[nodiscard]] std::optional<std::int64_t> next_due_ns() const;
  // Takes what has come, sends what is due.
  void serve(std::int64_t now_ns);

  // "bus-off", "restart", "error-passive", "node-reset NODE|all", "emergency NODE CODE", "mapping NODE wrong|right",
  // "node NODE on|off", "canopen on|off". None: the verb is another's.
  [[nodiscard]] std::optional<std::string> command(const std::vector<std::string>& words);
  // Members of a JSON object.
  [[nodiscard]] std::string status() const;
  void set_drift(double ppm) noexcept;

 private:
  struct Pending {
    std::int64_t due_ns;
    ::can_frame frame;
  };
  struct Member {
    CanopenNode node;
    bool on = true;
    std::int64_t last_due_ns = 0;  // of what it has to send: in order
  };

  [[nodiscard]] bool happens(double probability);
  [[nodiscard]] Member* member(const std::string& word);
  void take(const WireFrame& frame, std::int64_t now_ns);
  void collect(Member& member, std::int64_t now_ns);
  void send_due(std::int64_t now_ns);

  std::string interface_;
  Responder& responder_;
  const std::function<std::int64_t()>& clock_;
  const SimulatedClock& time_;
  std::optional<CanWire> wire_;
  std::vector<::can_frame> out_;
  std::vector<Member> members_;
  std::vector<double> values_;
  std::vector<Pending> pending_;
  std::vector<WireFrame> received_;
  BusTrouble trouble_;
  std::int64_t silent_until_ns_ = 0;
  std::uint64_t syncs_ = 0, sent_ = 0, lost_ = 0, late_ = 0, refused_ = 0;
  std::mt19937_64 random_;
};

}  // namespace rigsim
