#include "daemon/estimate/measurement.hpp"

#include <algorithm>
#include <utility>

namespace dwell {

Measurement::Measurement(const Rig& rig, KeptDwells kept, Tell tell)
    : pipeline_(rig), taken_(rig.channels.size()), finished_(std::move(kept)), tell_(std::move(tell)) {}

void Measurement::take(const Record& record) {
  if (record.kind == Kind::sample) ++taken_[record.channel];
  note(pipeline_.push(record));
}

void Measurement::finish() { note(pipeline_.finish()); }

Measurement::Fate Measurement::fate(std::size_t channel) const noexcept {
  const std::uint64_t rejected = std::min(pipeline_.channel(static_cast<int>(channel)).rejected, taken_[channel]);
  return {taken_[channel] - rejected, rejected};
}

void Measurement::note(std::uint8_t change) {
  if ((change & kCompleted) != 0) {
    finished_.push(pipeline_.completed());
    tell_({RunEvent::Kind::dwell_finished, state_, finished_.list()->back()});
  }
  if ((change & kStateChanged) != 0 && pipeline_.state() != state_) {
    tell_({RunEvent::Kind::state_changed, state_, std::make_shared<const Dwell>(pipeline_.current())});
    state_ = pipeline_.state();
  }
}

}  // namespace dwell
