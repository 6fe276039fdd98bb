#include "core/transient/settling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/chance.hpp"
#include "core/fit/blocks.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/transient/hold_now.hpp"

namespace dwell {
namespace {

// Distance between two windows of a channel: the largest of those between their means and between their phasors.
double distance(const SettlingDetector::Reading& a, const SettlingDetector::Reading& b) noexcept {
  double squared = std::norm(a.relative - b.relative);
  for (std::size_t i = 0; i < a.others.size(); ++i) squared = std::max(squared, std::norm(a.others[i] - b.others[i]));
  return std::sqrt(squared);
}

}  // namespace

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

const SettlingDetector::Reading& SettlingDetector::reading(int window, int channel) const noexcept {
  return const_cast<SettlingDetector*>(this)->reading(window, channel);
}

std::complex<double> SettlingDetector::later_mean(int channel) const noexcept {
  if (windows_.empty()) return 0.0;
  const double from_s = 0.5 * (windows_.front().t_s + windows_.back().t_s);
  std::complex<double> sum = 0.0;
  double count = 0.0;
  for (int i = static_cast<int>(windows_.size()); i-- > 0 && windows_[static_cast<std::size_t>(i)].t_s >= from_s;) {
    if (!reading(i, channel).usable) continue;
    sum += reading(i, channel).relative;
    count += 1.0;
  }
  return count > 0 ? sum / count : 0.0;
}

// Keeps every stride-th window: a bounded number then covers any time since restart.
void SettlingDetector::remember(const Window& window, std::span<const Reading> readings) noexcept {
  if (++skipped_ < stride_) return;
  skipped_ = 0;
  if (windows_.size() == kHistory) {
    for (int i = 0; i < kHistory / 2; ++i) {
      windows_[static_cast<std::size_t>(i)] = windows_[2 * static_cast<std::size_t>(i)];
      for (int c = 0; c < channels_; ++c) reading(i, c) = reading(2 * i, c);
    }
    windows_.resize(kHistory / 2);
    stride_ *= 2;
  }
  windows_.push_back(window);
  for (int c = 0; c < channels_; ++c)
    reading(static_cast<int>(windows_.size()) - 1, c) = readings[static_cast<std::size_t>(c)];
}

// Transient allowed: tolerance × steady amplitude, at least what ten periods of the channel's noise resolve.
double SettlingDetector::allowed(const Reading& now) const noexcept {
  const double noise = sigmas::kNoise * std::sqrt(now.noise * 2 / (10 * std::max(1.0, now.samples)));
  return std::max(tolerance_ * std::abs(now.relative), noise);
}

// Whether an earlier window agrees with the newest, so that it may count after the fact.
bool SettlingDetector::agrees(int window, const Window& now, std::span<const Reading> readings) const noexcept {
  const Window& then = windows_[static_cast<std::size_t>(window)];
  // The drive must agree more closely than the channels: a ramp of the drive is no transient that decays.
  const double u_table = std::hypot(then.table_u, now.table_u);
  if (std::abs(then.table_amplitude - now.table_amplitude) >
      std::max(kToleranceShare * tolerance_ * now.table_amplitude, sigmas::kNoise * u_table))
    return false;
  for (int c = 0; c < channels_; ++c) {
    const Reading& a = reading(window, c);
    const Reading& b = readings[static_cast<std::size_t>(c)];
    if (!a.usable || !b.usable) continue;
    // The noise is taken from the newest window only: the residuals of an earlier one may hold a transient.
    if (distance(a, b) > std::max(0.5 * tolerance_ * std::abs(b.relative), sigmas::kNoise * 2 * b.u)) return false;
    if (a.variance > b.variance * (1 + sigmas::kNoise * 2 / std::sqrt(std::max(1.0, b.samples))) +
                         std::norm(0.5 * tolerance_ * b.relative))
      return false;
  }
  return true;
}

// While much of the transient is left, the coefficients are off, and so is the T that they give: takes the longest T of
// the last quarter of the hold. A chain that would not decay gives none: T is then a sixth of the time watched. A
// transient of that T is gone, and a longer one shows as a difference between any two windows.
SettlingDetector::Decay SettlingDetector::decay(const Window& now, double period_s) const noexcept {
  const double seen_s = windows_.empty() ? 0.0 : now.t_s - windows_.front().t_s;
  double T = 0.0;
  bool known = std::isfinite(now.time_constant_s);
  for (std::size_t i = windows_.size(); i-- > 0 && windows_[i].t_s > now.t_s - 0.25 * seen_s;) {
    known = known && std::isfinite(windows_[i].time_constant_s);
    T = std::max(T, windows_[i].time_constant_s);
  }
  if (known) return {std::max(T, now.time_constant_s), 1.01 * period_s};
  return {seen_s / 6, std::max(1.01 * period_s, seen_s - seen_s / 6)};
}

// The largest transient that may be left in channel c. b: its newest reading.
double SettlingDetector::most_left(int c, const Reading& b, double t_s, const Decay& decay) const noexcept {
  double left = INFINITY, latest = 0.0;
  for (int i = 0; i < static_cast<int>(windows_.size()); ++i) {
    const double apart = t_s - windows_[static_cast<std::size_t>(i)].t_s;
    const double q = decay.T > 0 ? std::exp(-apart / decay.T) : 0.0;
    // Several modes can cancel in one window, but hardly in all windows of a period.
    double difference = 0.0, power = 0.0;
    bool seen = false;
    for (int j = std::max(0, i - kQuarters + 1); j <= i; ++j) {
      const Reading& a = reading(j, c);
      if (!a.usable) continue;
      seen = true;
      difference = std::max(difference, distance(a, b) + sigmas::kNoise * std::hypot(a.u, b.u));
      // The variance of a variance from N residuals is 2/N of its square.
      power = std::max(power,
                       a.variance - b.variance +
                           sigmas::kNoise * 2 * std::max(a.variance, b.variance) / std::sqrt(std::max(1.0, b.samples)));
    }
    // The last windows overlap the newest: their difference beyond the noise counts as it is.
    if (apart <= decay.as_it_is_s) {
      const Reading& a = reading(i, c);
      latest = std::max(latest, distance(a, b) - sigmas::kNoise * std::numbers::sqrt2 * std::hypot(a.u, b.u));
      continue;
    }
    if (!seen) continue;  // the channel was lost: its windows show nothing
    left =
        std::min(left, std::max(difference * q / (1 - q), std::sqrt(2 * std::max(0.0, power) * q * q / (1 - q * q))));
  }
  return std::max(left, latest);
}

// rms distance between the newest reading of channel c and its windows from `from` on, within one time constant T.
double SettlingDetector::spread(int c, const Reading& newest, int from, double T) const noexcept {
  if (!newest.usable) return 0.0;
  const double until_s = windows_[static_cast<std::size_t>(from)].t_s + T;
  double sum = 0.0, compared = 0.0;
  for (int i = from; i < static_cast<int>(windows_.size()); ++i) {
    if (compared > 0 && windows_[static_cast<std::size_t>(i)].t_s > until_s) break;
    sum += std::norm(reading(i, c).relative - newest.relative);
    compared += 1;
  }
  return std::sqrt(sum / compared);
}

SettlingDetector::Verdict SettlingDetector::update(std::int64_t first, std::int64_t last, double t_s,
                                                   double table_amplitude, double table_u,
                                                   std::span<const Reading> readings, double period_s,
                                                   double time_constant_s) noexcept {
  const Window now{first, last, t_s, table_amplitude, table_u, time_constant_s};
  const Decay decay = this->decay(now, period_s);
  Verdict verdict;
  double longest = 0.0;  // expected time left
  for (int c = 0; c < channels_; ++c) {
    const Reading& b = readings[static_cast<std::size_t>(c)];
    if (!b.usable) continue;
    const double ratio = most_left(c, b, t_s, decay) / allowed(b);
    if (ratio > verdict.worst_left || verdict.worst_channel < 0) verdict.worst_left = ratio, verdict.worst_channel = c;
    if (ratio > 1 && std::isfinite(ratio)) longest = std::max(longest, decay.T * std::log(ratio));
  }

  // How far back the windows agree with this one.
  const int count = static_cast<int>(windows_.size());
  int agreeing = count;
  while (agreeing > 0 && agrees(agreeing - 1, now, readings)) --agreeing;
  const double agreed_s =
      agreeing < count ? t_s - windows_[static_cast<std::size_t>(agreeing)].t_s + period_s : period_s;
  const double wanted_s = kPeriodsToTell * period_s - agreed_s;
  verdict.settled = verdict.worst_left <= 1 && wanted_s <= 1e-9 * period_s;
  if (verdict.settled) {
    for (int c = 0; c < channels_; ++c)
      left_[static_cast<std::size_t>(c)] = spread(c, readings[static_cast<std::size_t>(c)], agreeing, decay.T);
    // The window before did not agree, and the first that does may hold the end of what it saw: skip a quarter.
    verdict.from_serial = windows_[static_cast<std::size_t>(agreeing)].first + (agreeing == 0 ? 0 : 1);
  } else {
    verdict.settles_in_s = std::max(longest, std::max(0.0, wanted_s));
    if (verdict.worst_left <= 1) verdict.worst_channel = -1;
  }
  remember(now, readings);
  return verdict;
}

}  // namespace dwell
