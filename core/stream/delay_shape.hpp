// Learns how arrivals scatter about the grid of a device's clock, so that late readings can be told from losses.
//
// A forgetting histogram of the deviations, in periods, and its logarithm. It assumes no shape: the scheduler's delays
// may be uniform, one-sided or have two humps.
//
// Fixed storage, no allocation. Bound to one thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace dwell {

class DelayShape {
 public:
  static constexpr double kEarliest = -3.0;  // periods; deviations beyond count in the outermost bins
  static constexpr double kLatest = 4.0;

  // Adds a deviation in periods. It counts in log_likelihood() after the next learn(), at most kMemory / 2 later.
  void add(double deviation) noexcept {
    counts_[bin(deviation)] += 1.0;
    if (++fresh_ == kMemory / 2) learn();
  }
  // Updates the likelihoods with the deviations added. Older deviations then weigh half.
  void learn() noexcept {
    if (fresh_ == 0) return;
    fresh_ = 0;
    // Floors for deviations not seen yet: a reading may always be late; an early one is hardly possible.
    constexpr double kLate = 5e-3, kEarly = 1e-4;
    double total = 0.0;
    std::size_t top = 0;
    for (std::size_t i = 0; i < kBins; ++i) {
      total += counts_[i];
      if (counts_[i] > counts_[top]) top = i;
    }
    for (std::size_t i = 0; i < kBins; ++i) {
      const double beside = 0.5 * (counts_[i > 0 ? i - 1 : 0] + counts_[i + 1 < kBins ? i + 1 : kBins - 1]);
      logs_[i] = std::log((0.8 * counts_[i] + 0.2 * beside) / total + (i < top ? kEarly : kLate));
    }
    for (double& count : counts_) count *= 0.5;
  }
  // Logarithm of the likelihood of a deviation, up to a constant, nats.
  [[nodiscard]] double log_likelihood(double deviation) const noexcept { return logs_[bin(deviation)]; }

 private:
  static constexpr double kBinsPerPeriod = 8.0;
  static constexpr std::size_t kBins = 56;
  static constexpr int kMemory = 512;  // deviations
  static std::size_t bin(double deviation) noexcept {
    const double at = (std::clamp(deviation, kEarliest, kLatest) - kEarliest) * kBinsPerPeriod;
    return std::min(static_cast<std::size_t>(at), kBins - 1);
  }
  std::array<double, kBins> counts_{}, logs_{};
  int fresh_ = 0;
};

}  // namespace dwell
