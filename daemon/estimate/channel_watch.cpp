#include "daemon/estimate/channel_watch.hpp"

#include <algorithm>
#include <cstdio>

#include "core/base/instants.hpp"

namespace dwell {
namespace {
constexpr double kSilentIntervals = 20.0;
constexpr double kShortestSilence_ns = 1e9;
constexpr double kLongestSilence_ns = 600e9;
constexpr std::int64_t kRateSpan_ns = 1'000'000'000;

std::int64_t silence_ns(double rate_hz) {
  const double intervals_ns = rate_hz > 0.0 ? kSilentIntervals * kNsPerS / rate_hz : 0.0;
  return static_cast<std::int64_t>(std::clamp(intervals_ns, kShortestSilence_ns, kLongestSilence_ns));
}
}  // namespace

ChannelWatch::ChannelWatch(double nominal_rate_hz, std::int64_t now_ns)
    : since_ns_(now_ns), silence_ns_(silence_ns(nominal_rate_hz)), rate_since_ns_(now_ns) {}

bool ChannelWatch::sample(std::int64_t t_ns, std::int64_t now_ns) noexcept {
  heard(now_ns);
  newest_ns_ = std::max(newest_ns_, t_ns);
  if (fault_ == Fault::none || t_ns <= since_ns_) return false;
  fault_ = Fault::none;
  reason_.clear();
  since_ns_ = t_ns;
  return true;
}

bool ChannelWatch::said(std::int64_t t_ns, Fault fault, const char* reason) {
  const bool words = reason != nullptr && *reason != '\0';
  if (fault_ == fault) {
    if (fault != Fault::none && words) reason_ = reason;
    return false;
  }
  fault_ = fault;
  since_ns_ = t_ns;
  if (fault == Fault::none) {
    reason_.clear();
  } else {
    reason_ = words ? reason : to_string(fault);
  }
  return true;
}

bool ChannelWatch::fell_silent(std::int64_t now_ns) {
  const std::int64_t quiet_ns = now_ns - std::max(since_ns_, heard_ns_);
  if (fault_ != Fault::none || quiet_ns <= silence_ns_) return false;
  char words[96];
  std::snprintf(words, sizeof words, "nothing received for %.1f s although the device reports no fault",
                static_cast<double>(quiet_ns) / kNsPerS);
  return said(now_ns, Fault::silent, words);
}

void ChannelWatch::measure_rate(std::int64_t now_ns) noexcept {
  const std::int64_t span_ns = now_ns - rate_since_ns_;
  if (span_ns < kRateSpan_ns) return;
  rate_hz_ = static_cast<double>(samples_ - rate_samples_) * kNsPerS / static_cast<double>(span_ns);
  rate_since_ns_ = now_ns;
  rate_samples_ = samples_;
}

}  // namespace dwell
