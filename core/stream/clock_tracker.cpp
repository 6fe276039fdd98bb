#include "core/stream/clock_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/instants.hpp"

namespace dwell {
namespace {

// Mean absolute deviations from the clock beyond which an arrival is a stall and does not move it.
constexpr double kRejection = 6.0;
constexpr double kLeastSpread = 1e-4;  // periods: keeps the rejection limit above zero where arrivals hardly jitter

}  // namespace

void ClockTracker::begin(const ArrivalGrid& grid, std::int64_t begin_ns, std::size_t count,
                         double nominal_ns) noexcept {
  whole_ns_ = begin_ns;
  part_ns_ = grid.last_ns;
  period_ns_ = grid.period_ns;
  nominal_ns_ = nominal_ns;
  memory_ = std::max(32.0, kMemory_s * kNsPerS / period_ns_);
  age_ = static_cast<double>(count);
  spread_ = std::max(grid.spread, kLeastSpread);
  variance_ = 1.5 * spread_ * spread_;
  mistrusted_ = 0.0;
}

double ClockTracker::follow(std::int64_t arrival_ns) noexcept {
  part_ns_ += period_ns_;
  const double late = (static_cast<double>(arrival_ns - whole_ns_) - part_ns_) / period_ns_;
  const double limit = std::max(kRejection * spread_, 10.0 * kLeastSpread);

  age_ = std::min(age_ + 1.0, 3.0 * memory_);
  if (std::abs(late) <= limit) {
    const double theta = 1.0 - 1.0 / memory_;
    const double alpha = std::max((4.0 * age_ - 2.0) / (age_ * (age_ + 1.0)), 1.0 - theta * theta);
    const double beta = std::max(6.0 / (age_ * (age_ + 1.0)), (1.0 - theta) * (1.0 - theta));
    part_ns_ += alpha * late * period_ns_;
    period_ns_ += beta * late * period_ns_;
    if (nominal_ns_ > 0.0) {
      const double tracked_ns = period_ns_;
      period_ns_ = std::clamp(tracked_ns, nominal_ns_ * (1.0 - kNominalRange), nominal_ns_ * (1.0 + kNominalRange));
      mistrusted_ += ((period_ns_ == tracked_ns ? 0.0 : 1.0) - mistrusted_) / memory_;
    }
  }
  spread_ = std::max(kLeastSpread, spread_ + (std::min(std::abs(late), limit) - spread_) / 256.0);
  variance_ += (late * late - variance_) / std::min(age_, memory_);

  const double whole = std::floor(part_ns_);
  whole_ns_ += static_cast<std::int64_t>(whole);
  part_ns_ -= whole;
  return late;
}

// The half width of a rectangular distribution is √3 standard deviations. The standard deviation of an arrival is 1.25
// times its mean absolute deviation (1.15 to 1.25 for all likely shapes). The instant is the end of a line through
// `age` arrivals, 4 / age of their variance, or the value of a fading memory, 1.25 / memory.
double ClockTracker::half_ns() const noexcept {
  const double sigma_ns = 1.25 * spread_ * period_ns_;
  return std::numbers::sqrt3 * sigma_ns * std::sqrt(std::max(4.0 / age_, 1.25 / memory_));
}

double ClockTracker::jitter_ns() const noexcept { return std::sqrt(variance_) * period_ns_; }

}  // namespace dwell
