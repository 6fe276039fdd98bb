#include "core/settling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace dwell {

SettlingDetector::SettlingDetector(int channels, double tolerance) : channels_(channels), tolerance_(tolerance) {
  windows_.reserve(kHistory);
  left_.resize(static_cast<std::size_t>(channels));
  readings_.resize(static_cast<std::size_t>(kHistory) * static_cast<std::size_t>(channels));
  restart();
}

void SettlingDetector::restart() noexcept {
  windows_.clear();
  stride_ = 1;
  skipped_ = 0;
}

SettlingDetector::Reading& SettlingDetector::reading(int window, int channel) noexcept {
  return readings_[static_cast<std::size_t>(window) * static_cast<std::size_t>(channels_) +
                   static_cast<std::size_t>(channel)];
}

// Keeps every stride-th window, so that any time since restart is covered by a bounded number of them.
void SettlingDetector::remember(const Window& window, std::span<const Reading> readings) noexcept {
  if (++skipped_ < stride_) return;
  skipped_ = 0;
  if (windows_.size() == kHistory) {
    for (int i = 0; i < kHistory / 2; ++i) {
      windows_[static_cast<std::size_t>(i)] = windows_[static_cast<std::size_t>(2 * i)];
      for (int c = 0; c < channels_; ++c) reading(i, c) = reading(2 * i, c);
    }
    windows_.resize(kHistory / 2);
    stride_ *= 2;
  }
  windows_.push_back(window);
  for (int c = 0; c < channels_; ++c)
    reading(static_cast<int>(windows_.size()) - 1, c) = readings[static_cast<std::size_t>(c)];
}

// tolerance × steady amplitude; a channel that hardly moves is held to what ten periods of its noise resolve.
double SettlingDetector::allowed(const Reading& now) const noexcept {
  const double noise = kSure * std::sqrt(now.variance * 2 / (10 * std::max(1.0, now.samples)));
  return std::max(tolerance_ * std::abs(now.relative), noise);
}

// Whether an earlier window tells the same as the newest: what may be counted after the fact.
bool SettlingDetector::agrees(int window, const Window& now, std::span<const Reading> readings) noexcept {
  const Window& then = windows_[static_cast<std::size_t>(window)];
  // The drive must agree more closely than the channels: a ramp is no transient that decays.
  const double u_table = std::hypot(then.table_u, now.table_u);
  if (std::abs(then.table_amplitude - now.table_amplitude) >
      std::max(0.1 * tolerance_ * now.table_amplitude, kSure * u_table))
    return false;
  for (int c = 0; c < channels_; ++c) {
    const Reading& a = reading(window, c);
    const Reading& b = readings[static_cast<std::size_t>(c)];
    if (!a.usable || !b.usable) continue;
    const double u = std::hypot(a.u, b.u);
    if (std::abs(a.relative - b.relative) >
        std::max(0.5 * tolerance_ * std::abs(b.relative), kSure * std::numbers::sqrt2 * u))
      return false;
  }
  return true;
}

SettlingDetector::Verdict SettlingDetector::update(std::int64_t first, std::int64_t last, double t_s,
                                                   double table_amplitude, double table_u,
                                                   std::span<const Reading> readings, double period_s,
                                                   double time_constant_s) noexcept {
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  const Window now{first, last, t_s, table_amplitude, table_u};
  Verdict verdict;
  verdict.settles_in_s = kNotKnown;
  const double seen_s = windows_.empty() ? 0.0 : t_s - windows_.front().t_s;
  double T = time_constant_s;
  if (!std::isfinite(T)) T = seen_s;
  double longest = 0.0;  // expected time left
  for (int c = 0; c < channels_; ++c) {
    const Reading& b = readings[static_cast<std::size_t>(c)];
    if (!b.usable) continue;
    const double limit = allowed(b);
    double left = 0.0;
    for (int i = 0; i < static_cast<int>(windows_.size()); ++i) {
      const Reading& a = reading(i, c);
      const double apart = t_s - windows_[static_cast<std::size_t>(i)].t_s;
      if (!a.usable) continue;
      const double difference = std::abs(a.relative - b.relative) - kSure * std::numbers::sqrt2 * std::hypot(a.u, b.u);
      // The variance of a variance from N residuals is 2/N of its square.
      const double power = a.variance - b.variance - kSure * 2 * b.variance * std::sqrt(1 / std::max(1.0, b.samples));
      const double q = T > 0 ? std::exp(-apart / T) : 0.0;
      const bool recent = apart <= 1.01 * period_s;
      // Over less than a period the windows overlap and differ by part of the transient only: q / (1 - q) would be
      // taken of noise. Such a difference counts as it is.
      const double by_phasor = recent ? 1.0 : q / (1 - q);
      const double by_residual = recent ? 1.0 : q * q / (1 - q * q);
      if (difference > 0) left = std::max(left, difference * by_phasor);
      if (power > 0) left = std::max(left, std::sqrt(2 * power * by_residual));
    }
    const double ratio = left / limit;
    if (ratio > verdict.worst_left || verdict.worst_channel < 0) verdict.worst_left = ratio, verdict.worst_channel = c;
    if (ratio > 1) longest = std::max(longest, T * std::log(ratio));
  }

  // How far back the windows agree with this one.
  int agreeing = static_cast<int>(windows_.size());
  while (agreeing > 0 && agrees(agreeing - 1, now, readings)) --agreeing;
  const double agreed_s = agreeing < static_cast<int>(windows_.size())
                              ? t_s - windows_[static_cast<std::size_t>(agreeing)].t_s + period_s
                              : period_s;
  const double wanted_s = kPeriods * period_s - agreed_s;
  if (verdict.worst_left <= 1 && wanted_s <= 1e-9 * period_s) {
    verdict.settled = true;
    verdict.settles_in_s = 0.0;
    const Window& from = windows_[static_cast<std::size_t>(agreeing)];
    // The window before did not agree, and this one may hold the end of what it saw: a quarter is left out.
    for (int c = 0; c < channels_; ++c) {
      double sum = 0.0, count = 0.0;
      for (int i = agreeing; i < static_cast<int>(windows_.size()); ++i) {
        if (count > 0 && windows_[static_cast<std::size_t>(i)].t_s > from.t_s + T) break;
        sum += std::norm(reading(i, c).relative - readings[static_cast<std::size_t>(c)].relative);
        count += 1;
      }
      left_[static_cast<std::size_t>(c)] = readings[static_cast<std::size_t>(c)].usable ? std::sqrt(sum / count) : 0.0;
    }
    verdict.from_serial = agreeing == 0 ? from.first : from.first + 1;
  } else {
    verdict.settles_in_s = std::max(longest, std::max(0.0, wanted_s));
    if (verdict.worst_left <= 1) verdict.worst_channel = -1;
  }
  remember(now, readings);
  return verdict;
}

}  // namespace dwell
