// The state machine of the dwell: which states there are, and what leads from one to another (docs/states.md has the
// picture). It decides nothing by itself: whoever watches the stream tells what has happened, each event by a function
// of its own, and an event that means nothing in a state leaves it as it is.
#pragma once

#include <cstdint>

#include "core/result/dwell.hpp"

namespace dwell {

// The order matters to at_rest() and awaits_reason(). Outsiders see only the State of each (state_of).
enum class Phase : std::uint8_t {
  idle,                // the table does not move
  interlocked,         // the interlock is open: nothing begins, however the table moves
  unseen,              // the drive cannot be seen: its channel does not deliver, or its sync pulses do not come
  unseen_interlocked,  // both
  settling,            // the drive is steady, the transient is not over
  asked_again,         // the transient seems to be over, but readings are rounded: more data must say so again
  measuring,           // the data count
  // Settling while the dwell before waits for the reason of its end: has the drive changed, or does it stop?
  settling_after_change,
  asked_again_after_change,
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
  [[nodiscard]] bool asked_again() const noexcept {
    return phase_ == Phase::asked_again || phase_ == Phase::asked_again_after_change;
  }
  [[nodiscard]] bool measuring() const noexcept { return state() == State::measuring; }
  // A dwell has ended, and is kept back until the reason is known.
  [[nodiscard]] bool awaits_reason() const noexcept { return phase_ >= Phase::settling_after_change; }
  // Number of the dwell that is on, or of the last one: 1 … in the run.
  [[nodiscard]] int index() const noexcept { return index_; }
  // How often the drive has left its hold since the dwell was armed.
  [[nodiscard]] int restarts() const noexcept { return restarts_; }
  // Whether the State is, or was in between, another than at the last call.
  [[nodiscard]] bool changed() noexcept;

  // The table moves while no dwell is on, and nothing bars: a dwell is armed. Not while interlocked.
  void arm() noexcept;
  // The table moves while no dwell is on, but the frequency's reference does not come, or the interlock is open.
  void bar() noexcept;
  // The drive has left its steady motion. While measuring the dwell ends, its reason open, and the next one is armed;
  // while settling it begins anew.
  void leave_hold() noexcept;
  // Registers have come to be held, or no longer are: it settles anew.
  void settle_anew() noexcept;
  // While settling: whether the verdict waits to be asked again.
  void ask_again(bool again) noexcept;
  // While settling, and no dwell waits for its reason (a drive that is steady enough to measure has changed): the data
  // count from now on. While measuring: a better fit says that they do not.
  void begin_to_measure() noexcept;
  void take_back() noexcept;
  // The reason is known why the dwell before ended: the one armed since then goes on …
  void go_on() noexcept;
  // … or was none: its number is taken back. So it is of one that never settled and was hardly begun.
  void forget_dwell() noexcept { --index_; }
  // Every dwell is over: the table rests or the run ends; the drive cannot be seen.
  void rest() noexcept { go(interlocked() ? Phase::interlocked : Phase::idle); }
  void lose_sight() noexcept { go(interlocked() ? Phase::unseen_interlocked : Phase::unseen); }
  // The level of the interlock, while no dwell is on: its loss ends a dwell first.
  void interlock(bool closed) noexcept;

 private:
  void go(Phase next) noexcept;

  Phase phase_ = Phase::idle;
  bool changed_ = false;
  int index_ = 0, restarts_ = 0;
};

}  // namespace dwell
