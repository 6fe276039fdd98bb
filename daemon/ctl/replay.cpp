#include "daemon/ctl/replay.hpp"

namespace dwell::ctl {

void Replay::break_off() {
  ended_.clear();
  if (!finished_) finish();
}

void Replay::finish() {
  finished_ = true;
  for (std::uint8_t change = pipeline_.flush(); change != kNothing; change = pipeline_.flush()) note(change);
  note(pipeline_.finish());
}

std::optional<Dwell> Replay::current() const {
  if (pipeline_.busy()) return std::nullopt;
  return pipeline_.pipeline().current();
}

std::optional<DwellDraft> Replay::draft() const {
  if (pipeline_.busy()) return std::nullopt;
  return pipeline_.pipeline().current_draft();
}

void Replay::note(std::uint8_t change) {
  if ((change & kCompleted) != 0) ended_.push_back(pipeline_.pipeline().completed());
  if ((change & kStateChanged) != 0) state_changed_ = true;
}

}  // namespace dwell::ctl
