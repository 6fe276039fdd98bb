// The state machine of the dwell: its states, and the events that lead from one to another (picture: docs/states.md).
// It decides nothing. The pipeline reports each event by a member function. In states where an event has no meaning, it
// changes nothing.
#pragma once

#include <cstdint>

#include "core/result/dwell.hpp"

namespace dwell {

// at_rest() and awaits_reason() rely on the order. Outsiders see only the State of each (state_of).
enum class Phase : std::uint8_t {
  idle,                // the table does not move
  interlocked,         // the interlock is open: nothing begins, however the table moves
  unseen,              // the drive cannot be seen: its channel is silent or stuck, or its sync pulses do not come
  unseen_interlocked,  // both
  settling,            // the drive is steady, the transient is not over
  unconfirmed,         // the transient seems to be over, but readings are rounded: more data must confirm it
  measuring,           // the data count
  // Settling, while it is not known why the dwell before ended: has the drive changed, or does it stop?
  settling_after_change,
  unconfirmed_after_change,
};

[[nodiscard]] State state_of(Phase phase) noexcept;

// Bound to one thread, real-time safe.
class DwellStates {
 public:
  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  [[nodiscard]] State state() const noexcept { return state_of(phase_); }
  // No dwell is on.
  [[nodiscard]] bool at_rest() const noexcept { return phase_ <= Phase::unseen_interlocked; }
  [[nodiscard]] bool interlocked() const noexcept {
    return phase_ == Phase::interlocked || phase_ == Phase::unseen_interlocked;
  }
  [[nodiscard]] bool settling() const noexcept { return state() == State::settling; }
  [[nodiscard]] bool unconfirmed() const noexcept {
    return phase_ == Phase::unconfirmed || phase_ == Phase::unconfirmed_after_change;
  }
  [[nodiscard]] bool measuring() const noexcept { return state() == State::measuring; }
  // A dwell has ended and is kept back until it is known why.
  [[nodiscard]] bool awaits_reason() const noexcept { return phase_ >= Phase::settling_after_change; }
  // Number in the run, 1 …, of the present dwell, else of the last one.
  [[nodiscard]] int index() const noexcept { return index_; }
  // How often the drive has left its hold since the dwell was armed.
  [[nodiscard]] int restarts() const noexcept { return restarts_; }
  // Whether the State has changed since the last call, even if it has changed back.
  [[nodiscard]] bool changed() noexcept;

  // The table moves, and nothing bars a dwell: one is armed if none is on. Ignored while interlocked.
  void arm() noexcept;
  // The table moves while no dwell is on, but the frequency's reference is missing, or the interlock is open.
  void bar() noexcept;
  // The drive has left its steady motion. A dwell that measures ends, the reason open, and the next one is armed. A
  // dwell that settles begins anew.
  void leave_hold() noexcept;
  // A register began or ceased to be held: the dwell settles anew.
  void settle_anew() noexcept;
  // While settling: whether the verdict must be confirmed by more data.
  void set_unconfirmed(bool again) noexcept;
  // While settling: the verdict is given. Ignored while the dwell before waits for its reason: call go_on() first.
  void begin_to_measure() noexcept;
  // While measuring: a better fit says that the verdict was premature. The dwell settles again.
  void take_back() noexcept;
  // It is known why the dwell before ended: the one armed since then goes on.
  void go_on() noexcept;
  // Takes back the number of a dwell that is not reported.
  void forget_dwell() noexcept { --index_; }
  // No dwell is on any more. rest(): the table rests or the run has ended; lose_sight(): the drive cannot be seen.
  void rest() noexcept { go(interlocked() ? Phase::interlocked : Phase::idle); }
  void lose_sight() noexcept { go(interlocked() ? Phase::unseen_interlocked : Phase::unseen); }
  // The interlock's level, while no dwell is on. If it opens during a dwell, the dwell must be ended first.
  void interlock(bool closed) noexcept;

 private:
  void go(Phase next) noexcept;

  Phase phase_ = Phase::idle;
  bool changed_ = false;
  int index_ = 0, restarts_ = 0;
};

}  // namespace dwell
