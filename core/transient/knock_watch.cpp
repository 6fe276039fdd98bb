#include "core/transient/knock_watch.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/chance.hpp"

namespace dwell {

void KnockWatch::begin_hold(std::int64_t steady_ns) noexcept {
  free_since_ns_ = steady_ns;
  alarm_ns_.reset();
  any_ = false;
}

bool KnockWatch::sees_knock(HoldFit& fit, const ResidualNoise& noise, const HoldNow& now,
                            std::int64_t from_ns) noexcept {
  std::fill(newest_.begin(), newest_.end(), Newest{});
  fit.each_residual(from_ns, [&](const SampleHistory::Sample& sample, double r) {
    Newest& of = newest_[static_cast<std::size_t>(sample.channel)];
    of.squares += r * r;
    of.count += 1.0;
  });
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    const int c = static_cast<int>(i);
    const Newest& of = newest_[i];
    if (now.channels[i].imposed || !(of.count > 0) || !noise.known(c)) continue;
    const double variance = std::max(noise.variance(c), fit.fit().variance(c));
    // Noise alone exceeds it once in 10⁷ quarters of a channel, some 30 hours of one at 25 Hz. A false alarm costs a
    // refit, no data. The second term: χ² of few readings has a longer tail than a normal number.
    const double beyond =
        sigmas::kAlarm * std::sqrt(2 / of.count + 2 / noise.freedom(c)) + sigmas::kAlarm * sigmas::kAlarm / of.count;
    if (of.squares > variance * of.count * (1 + beyond)) return true;
  }
  return false;
}

void KnockWatch::alarm(std::int64_t end_ns) noexcept {
  alarm_ns_ = end_ns;
  any_ = true;
}

}  // namespace dwell
