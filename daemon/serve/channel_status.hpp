// How a channel stands, in one word. Pure, thread-safe.
#pragma once

#include <string>

#include "daemon/estimate/snapshot.hpp"

namespace dwell {

// "ok", what is wrong with its readings ("stuck"), or why it does not deliver ("timeout").
[[nodiscard]] inline const char* status_of(const ChannelView& channel) noexcept {
  if (channel.fault != Fault::none) return to_string(channel.fault);
  if (channel.overrange) return to_string(Condition::overrange);
  // A channel that delivers has been heard; its condition may not have been judged yet.
  return to_string(channel.condition == Condition::unheard ? Condition::ok : channel.condition);
}

// How it stands, as a line for people: the word, and the reason where it says more. Allocates.
[[nodiscard]] inline std::string status_text(const ChannelView& channel) {
  const std::string word = status_of(channel);
  const std::string& reason = channel.fault != Fault::none ? channel.reason : channel.condition_reason;
  if (reason.empty()) return word;
  return reason.starts_with(word) ? reason : word + ": " + reason;
}

// Time since its newest reading was taken in, s; NaN: never heard. now_ns: CLOCK_MONOTONIC_RAW.
[[nodiscard]] inline double reading_age_s(const ChannelView& channel, std::int64_t now_ns) noexcept {
  if (channel.heard_ns < 0) return kNaN;
  const double age_s = static_cast<double>(now_ns - channel.heard_ns) * 1e-9;
  return age_s > 0.0 ? age_s : 0.0;
}

// Samples per second over the last second or so, Hz; NaN: it does not deliver.
[[nodiscard]] inline double delivered_rate_hz(const ChannelView& channel) noexcept {
  return channel.fault == Fault::none ? channel.rate_hz : kNaN;
}

// Standard deviation of the stamps from the clock recognized in them, s; NaN: none is, or it does not deliver.
[[nodiscard]] inline double delivered_jitter_s(const ChannelView& channel) noexcept {
  return channel.fault == Fault::none ? channel.clock.jitter_s : kNaN;
}

}  // namespace dwell
