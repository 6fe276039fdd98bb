#include "daemon/estimate/channel_watch.hpp"

#include <algorithm>
#include <cstdio>

namespace dwell {
namespace {
constexpr double kNsPerS = 1e9;
constexpr double kSilentIntervals = 20.0;
constexpr std::int64_t kShortestSilence_ns = 1'000'000'000;
constexpr std::int64_t kLongestSilence_ns = 600'000'000'000;
constexpr std::int64_t kRateSpan_ns = 1'000'000'000;
}  // namespace

ChannelWatch::ChannelWatch(const std::vector<double>& nominal_rate_hz, std::int64_t now_ns)
    : channels_(nominal_rate_hz.size()) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Channel& channel = channels_[i];
    const double silence_ns = nominal_rate_hz[i] > 0.0 ? kSilentIntervals * kNsPerS / nominal_rate_hz[i] : 0.0;
    channel.silence_ns = static_cast<std::int64_t>(
        std::clamp(silence_ns, static_cast<double>(kShortestSilence_ns), static_cast<double>(kLongestSilence_ns)));
    channel.since_ns = now_ns;
    channel.rate_since_ns = now_ns;
  }
}

bool ChannelWatch::sample(std::size_t channel, std::int64_t t_ns, std::int64_t now_ns) noexcept {
  Channel& c = channels_[channel];
  heard(channel, now_ns);
  if (c.fault == Fault::none || t_ns <= c.since_ns) return false;
  c.fault = Fault::none;
  c.reason.clear();
  c.since_ns = t_ns;
  return true;
}

bool ChannelWatch::said(std::size_t channel, std::int64_t t_ns, Fault fault, const char* reason) {
  Channel& c = channels_[channel];
  if (c.fault == fault) {
    if (fault != Fault::none && reason != nullptr && *reason != '\0') c.reason = reason;
    return false;
  }
  c.fault = fault;
  c.since_ns = t_ns;
  if (fault == Fault::none) {
    c.reason.clear();
  } else {
    c.reason = reason != nullptr && *reason != '\0' ? reason : to_string(fault);
  }
  return true;
}

bool ChannelWatch::fell_silent(std::size_t channel, std::int64_t now_ns) {
  Channel& c = channels_[channel];
  const std::int64_t quiet_ns = now_ns - std::max(c.since_ns, c.heard_ns);
  if (c.fault != Fault::none || quiet_ns <= c.silence_ns) return false;
  char words[96];
  std::snprintf(words, sizeof words, "nothing received for %.1f s although the device reports no fault",
                static_cast<double>(quiet_ns) / kNsPerS);
  c.fault = Fault::silent;
  c.reason = words;
  c.since_ns = now_ns;
  return true;
}

void ChannelWatch::measure_rates(std::int64_t now_ns) noexcept {
  for (Channel& c : channels_) {
    const std::int64_t span_ns = now_ns - c.rate_since_ns;
    if (span_ns < kRateSpan_ns) continue;
    c.rate_hz = static_cast<double>(c.samples - c.rate_samples) * kNsPerS / static_cast<double>(span_ns);
    c.rate_since_ns = now_ns;
    c.rate_samples = c.samples;
  }
}

}  // namespace dwell
