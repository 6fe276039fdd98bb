#include "core/dwell/dwell_states.hpp"

#include <utility>

namespace dwell {

State state_of(Phase phase) noexcept {
  switch (phase) {
    case Phase::idle:
    case Phase::interlocked:
      return State::idle;
    case Phase::unseen:
    case Phase::unseen_interlocked:
      return State::fault;
    case Phase::settling:
    case Phase::unconfirmed:
    case Phase::settling_after_change:
    case Phase::unconfirmed_after_change:
      return State::settling;
    case Phase::measuring:
      return State::measuring;
  }
  return State::idle;
}

void DwellStates::go(Phase next) noexcept {
  if (state_of(next) != state()) changed_ = true;
  phase_ = next;
}

bool DwellStates::changed() noexcept { return std::exchange(changed_, false); }

void DwellStates::arm() noexcept {
  if (!at_rest() || interlocked()) return;
  ++index_;
  restarts_ = 0;
  go(Phase::settling);
}

void DwellStates::bar() noexcept {
  if (at_rest()) go(interlocked() ? Phase::interlocked : Phase::unseen);
}

void DwellStates::leave_hold() noexcept {
  if (measuring()) {
    ++index_;
    restarts_ = 0;
    return go(Phase::settling_after_change);
  }
  if (!settling()) return;
  ++restarts_;
  settle_anew();
}

void DwellStates::settle_anew() noexcept {
  if (settling()) go(awaits_reason() ? Phase::settling_after_change : Phase::settling);
}

void DwellStates::set_unconfirmed(bool again) noexcept {
  if (!settling()) return;
  if (awaits_reason())
    go(again ? Phase::unconfirmed_after_change : Phase::settling_after_change);
  else
    go(again ? Phase::unconfirmed : Phase::settling);
}

void DwellStates::begin_to_measure() noexcept {
  if (settling() && !awaits_reason()) go(Phase::measuring);
}

void DwellStates::take_back() noexcept {
  if (measuring()) go(Phase::settling);
}

void DwellStates::go_on() noexcept {
  if (phase_ == Phase::settling_after_change) go(Phase::settling);
  if (phase_ == Phase::unconfirmed_after_change) go(Phase::unconfirmed);
}

void DwellStates::interlock(bool closed) noexcept {
  if (phase_ == Phase::idle && !closed) return go(Phase::interlocked);
  if (phase_ == Phase::unseen && !closed) return go(Phase::unseen_interlocked);
  if (phase_ == Phase::interlocked && closed) return go(Phase::idle);
  if (phase_ == Phase::unseen_interlocked && closed) return go(Phase::unseen);
}

}  // namespace dwell
