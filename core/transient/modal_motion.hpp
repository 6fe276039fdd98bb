// The nonlinear parameters of the modal fit: frequency and drift of the drive, and the poles.
//
// Poles: rad/s, Im >= 0 (0: a real pole). Re < 0: a mode that decays. Re = 0: a steady line (mains hum), no transient.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

namespace dwell {

class ModalMotion {
 public:
  static constexpr int kMaxModes = 10;  // of more poles the first are kept
  // Relative standard uncertainty: of a pole or ω where the data tell nothing; of a frequency that is given.
  static constexpr double kOpen = 1.0, kGiven = 1e-12;

  // modes: capacity in poles, at most kMaxModes. All memory is allocated here.
  explicit ModalMotion(int modes)
      : poles_(static_cast<std::size_t>(std::min(modes, kMaxModes))), sizes_(poles_.size()) {}

  // omega: of the drive at t0, rad/s. rate: its drift, rad/s². Poles beyond the capacity are left out. `poles` may be
  // the span of poles().
  void restart(double omega, double rate, std::int64_t t0_ns, std::span<const std::complex<double>> poles) noexcept {
    omega_ = omega;
    rate_ = rate;
    t0_ns_ = t0_ns;
    count_ = std::min(poles.size(), poles_.size());
    if (poles.data() != poles_.data()) std::copy_n(poles.begin(), count_, poles_.begin());
    for (std::size_t m = 0; m < count_; ++m) sizes_[m] = std::abs(poles_[m]);
  }

  [[nodiscard]] std::span<const std::complex<double>> poles() const noexcept { return {poles_.data(), count_}; }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return poles_.size(); }
  // |λ| of pole m, rad/s.
  [[nodiscard]] double size(std::size_t m) const noexcept { return sizes_[m]; }
  // Whether pole m belongs to the transient and is no steady line.
  [[nodiscard]] bool decays(std::size_t m) const noexcept { return poles_[m].real() < 0; }

  [[nodiscard]] double omega() const noexcept { return omega_; }
  [[nodiscard]] double rate() const noexcept { return rate_; }
  [[nodiscard]] std::int64_t t0_ns() const noexcept { return t0_ns_; }
  // u = t - t0, s; the drive's angle ωu + rate u²/2 at t, rad.
  [[nodiscard]] double seconds(std::int64_t t_ns) const noexcept { return 1e-9 * static_cast<double>(t_ns - t0_ns_); }
  [[nodiscard]] double angle(std::int64_t t_ns) const noexcept {
    const double u = seconds(t_ns);
    return (omega_ + 0.5 * rate_ * u) * u;
  }

 private:
  std::vector<std::complex<double>> poles_;
  std::vector<double> sizes_;
  std::size_t count_ = 0;
  double omega_ = 0.0, rate_ = 0.0;
  std::int64_t t0_ns_ = 0;
};

}  // namespace dwell
