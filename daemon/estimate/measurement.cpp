#include "daemon/estimate/measurement.hpp"

#include <algorithm>
#include <utility>

namespace dwell {

Measurement::Measurement(const Rig& rig, KeptDwells kept, Tell tell)
    : pipeline_(rig), current_(pipeline().current()), finished_(std::move(kept)), tell_(std::move(tell)) {}

void Measurement::take(const Record& record) {
  ++taken_;
  note(pipeline_.push(record));
}

std::size_t Measurement::take_samples(std::span<const Record> records) noexcept {
  const std::size_t n = pipeline_.push_in_block(records);
  taken_ += n;
  return n;
}

void Measurement::finish() {
  for (std::uint8_t change = pipeline_.flush(); change != kNothing; change = pipeline_.flush()) note(change);
  note(pipeline_.finish());
}

const Dwell& Measurement::current() {
  if (pipeline_.busy()) return current_;
  current_ = pipeline().current();
  current_at_ = taken_;
  return current_;
}

Measurement::Fate Measurement::fate(std::size_t channel) const noexcept {
  const std::uint64_t taken = pipeline_.taken(channel);
  const std::uint64_t rejected = std::min(pipeline().channel(static_cast<int>(channel)).rejected, taken);
  return {taken - rejected, rejected};
}

void Measurement::note(std::uint8_t change) {
  if ((change & kCompleted) != 0) {
    finished_.push(pipeline().completed());
    tell_({RunEvent::Kind::dwell_finished, state_, finished_.list()->back()});
  }
  if ((change & kStateChanged) != 0 && pipeline().state() != state_) {
    tell_({RunEvent::Kind::state_changed, state_, std::make_shared<const Dwell>(current())});
    state_ = pipeline().state();
  }
}

}  // namespace dwell
