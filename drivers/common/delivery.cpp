#include "drivers/common/delivery.hpp"

namespace dwell::driver {

void Delivery::add(std::size_t channel, const Instant& instant, double raw) noexcept {
  Channel& to = channels_[channel];
  to.failures.end();
  if (to.told != DWELL_FAULT_NONE) {
    to.told = DWELL_FAULT_NONE;
    host_.state(to.index, DWELL_FAULT_NONE);
  }
  const bool advances = instant.t_ns > to.last_ns;
  to.last_ns = advances ? instant.t_ns : to.last_ns + 1;
  const unsigned flags =
      (instant.replaced || !advances ? DWELL_SAMPLE_STAMP_REPLACED : 0U) | (to.gap ? DWELL_SAMPLE_GAP : 0U);
  to.gap = false;
  scan_.push_back({to.last_ns, raw, instant.t_half_ns, to.index, static_cast<std::uint16_t>(flags)});
}

bool Delivery::push() noexcept {
  if (scan_.empty()) return false;
  host_.push(scan_);
  scan_.clear();
  return true;
}

void Delivery::lost(std::size_t channel) noexcept { channels_[channel].gap = channels_[channel].last_ns != INT64_MIN; }

void Delivery::lost() noexcept {
  for (std::size_t i = 0; i < channels_.size(); ++i) lost(i);
}

void Delivery::overflow(std::uint64_t frames, const std::string& who, std::int64_t now_ns) {
  if (frames == 0) return;
  host_.count(DWELL_FAULT_OVERFLOW, frames);
  lost();
  overflow_ += frames;
  if (!overflow_line_.due(now_ns)) return;
  host_.log(DWELL_WARNING, who + ": " + std::to_string(overflow_) + " frames were lost for lack of room");
  overflow_ = 0;
}

void Delivery::tell(std::size_t channel, dwell_fault fault, std::string_view reason) {
  Channel& of = channels_[channel];
  lost(channel);
  if (of.told == fault && of.reason == reason) return;
  of.told = fault;
  of.reason = reason;
  host_.state(of.index, fault, of.reason.c_str());
}

void Delivery::hold(dwell_fault fault, std::string_view reason) {
  held_ = true;
  for (std::size_t i = 0; i < channels_.size(); ++i) tell(i, fault, reason);
}

}  // namespace dwell::driver
