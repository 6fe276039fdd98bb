// How arrivals scatter about the grid of a device's clock, learnt from them: a histogram of deviations in periods that
// forgets, and its logarithm, for telling late readings from those that follow a loss. Whatever the shape of the
// scheduler's delays (uniform, one-sided, two humps), the likelihoods are its own.
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
  static constexpr double kEarliest = -3.0;  // deviations beyond go into the last bins
  static constexpr double kLatest = 4.0;

  // Tells with the next learn(), which it calls by itself now and then.
  void add(double deviation) noexcept {
    counts_[bin(deviation)] += 1.0;
    if (++fresh_ == kMemory / 2) learn();
  }
  // Takes what was added into the likelihoods; older deviations then weigh half.
  void learn() noexcept {
    if (fresh_ == 0) return;
    fresh_ = 0;
    // What has never been seen: late can always happen, early cannot.
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
  // Logarithm of the likelihood of a deviation, apart from a constant.
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
