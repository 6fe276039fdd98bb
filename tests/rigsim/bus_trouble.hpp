// What befalls a CAN bus whatever its nodes do: a controller that leaves it, and frames of a high priority that mean
// nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/rigsim/can_wire.hpp"
#include "tests/rigsim/device.hpp"

namespace rigsim {

// Bound to one thread.
class BusTrouble {
 public:
  // The frames that mean nothing have this identifier; faults.babble_hz says how often they come.
  BusTrouble(canid_t babble, const Faults& faults, std::uint64_t seed)
      : babble_(babble), faults_(faults), random_(seed ^ 0xBAB1EULL) {}

  // Between bus-off and restart: nobody sends anything.
  [[nodiscard]] bool off() const noexcept { return off_; }
  // When (CLOCK_MONOTONIC) the next meaningless frame is due; none: never.
  [[nodiscard]] std::optional<std::int64_t> due_ns() const noexcept;
  // Sends those that are due. How many clients lost one.
  unsigned babble(CanWire& wire, std::int64_t now_ns);
  // "bus-off", "restart", "error-passive", told on the wire, if any. None: the line is another's.
  [[nodiscard]] std::optional<std::string> command(const std::vector<std::string>& words, CanWire* wire);

 private:
  canid_t babble_;
  const Faults& faults_;
  std::int64_t babble_ns_ = 0;  // when the next one is due
  bool off_ = false;
  std::mt19937_64 random_;
};

}  // namespace rigsim
