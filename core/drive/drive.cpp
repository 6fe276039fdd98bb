#include "core/drive/drive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"

namespace dwell {

void DriveMonitor::restart() noexcept {
  seen_ = 0;
  frequencies_ = 0;
  amplitude_ = omega_ = 0.0;
  suspicious_ = since_good_ = 0;
}

void DriveMonitor::refer(double amplitude, double omega) noexcept {
  amplitude_ = amplitude;
  omega_ = omega;
  seen_ = std::max(seen_, kReference + seen_ % kQuarters);  // leaves seen_ % kQuarters, the place in last_, as it is
  frequencies_ = std::max(frequencies_, 1L);
}

double DriveMonitor::omega() const noexcept {
  return frequencies_ > 0 ? omega_ : std::numeric_limits<double>::quiet_NaN();
}

bool DriveMonitor::update(double centre_s, std::complex<double> Y, double u, double omega) noexcept {
  const double amplitude = std::abs(Y);
  bool other = false, good = true;
  if (seen_ > 0) {
    const double off = std::abs(amplitude - amplitude_);
    const double noise = sigmas::kShown * u * std::sqrt(1.0 + 1.0 / static_cast<double>(seen_));
    other = off > tolerance_ * amplitude_ + noise;
    good = off <= 0.1 * tolerance_ * amplitude_ + noise;
  }
  Window& before = last_[static_cast<std::size_t>(seen_ % kQuarters)];
  double measured = std::numeric_limits<double>::quiet_NaN();
  if (seen_ >= kQuarters && before.centre_s < centre_s) {
    const double step = centre_s - before.centre_s;
    const double turn = std::remainder(std::arg(Y * std::conj(before.Y)) - omega * step, kTwoPi);
    measured = omega + turn / step;
    const double noise = sigmas::kShown * std::hypot(u, before.u) / std::max(amplitude, 1e-300) / step;
    if (frequencies_ > 0) {
      const double off = std::abs(measured - omega_);
      other = other || off > 1.5 * tolerance_ * omega_ + noise;
      good = good && off <= 0.5 * tolerance_ * omega_ + noise;
    }
  }
  before = {centre_s, Y, u};
  since_good_ = good && !other ? 0 : since_good_ + 1;
  suspicious_ = other ? suspicious_ + 1 : 0;
  if (suspicious_ >= 2) return true;
  if (!other && seen_ < kReference) {
    amplitude_ += (amplitude - amplitude_) / static_cast<double>(seen_ + 1);
    if (std::isfinite(measured)) omega_ += (measured - omega_) / static_cast<double>(++frequencies_);
  }
  ++seen_;
  return false;
}

}  // namespace dwell
