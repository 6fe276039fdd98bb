// The regressors of ModalFit at one instant: constant, harmonics of the drive, natural oscillations, and the
// derivatives of these by their poles and by ω. From instant to instant the oscillations are turned rather than
// computed anew.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

namespace dwell {

// Bound to one thread. No allocation but in the constructor.
class ModalRegressors {
 public:
  static constexpr int kMaxModes = 10;  // the slowest; what decays faster is gone before it matters

  // modes: at most so many poles will be given.
  ModalRegressors(int harmonics, int modes);

  // poles: rad/s, those beyond the capacity are left out. omega: of the drive at t0, rad/s; rate: by which it drifts,
  // rad/s².
  void restart(double omega, double rate, std::int64_t t0_ns, std::span<const std::complex<double>> poles) noexcept;

  // At t: 1, sin, cos, then of each mode those of the real and the imaginary part of its amplitude; then the same of
  // the relative change of its pole, and of that of ω (of the fundamental, which tells most of it). Valid until the
  // next call. Real-time safe.
  [[nodiscard]] const Eigen::VectorXd& at(std::int64_t t_ns) noexcept {
    if (t_ns != evaluated_ns_) evaluate(t_ns);
    return x_;
  }

  // How many: of the steady motion, 2H+1; of the modes; of both; of the derivatives, two for each mode and two for ω.
  [[nodiscard]] Eigen::Index steady() const noexcept { return steady_; }
  [[nodiscard]] Eigen::Index modal() const noexcept { return 2 * static_cast<Eigen::Index>(count_); }
  [[nodiscard]] Eigen::Index linear() const noexcept { return steady() + modal(); }
  [[nodiscard]] Eigen::Index slopes() const noexcept { return modal() + 2; }
  [[nodiscard]] int harmonics() const noexcept { return harmonics_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return poles_.size(); }

  [[nodiscard]] std::span<const std::complex<double>> poles() const noexcept { return {poles_.data(), count_}; }
  // |λ| of each pole, rad/s.
  [[nodiscard]] std::span<const double> sizes() const noexcept { return {sizes_.data(), count_}; }
  [[nodiscard]] double omega() const noexcept { return omega_; }
  [[nodiscard]] double rate() const noexcept { return rate_; }
  [[nodiscard]] std::int64_t t0_ns() const noexcept { return t0_ns_; }
  // The drive's phase at t, rad; 0 at t0.
  [[nodiscard]] double angle(std::int64_t t_ns) const noexcept;

  // From t on mode m is as good as nothing: it costs no more until the next restart.
  void fade(std::size_t m, std::int64_t t_ns) noexcept { faded_ns_[m] = t_ns; }
  [[nodiscard]] std::int64_t faded_ns(std::size_t m) const noexcept { return faded_ns_[m]; }

 private:
  // What the drive's and the modes' turns are multiplied by when dt_ns go by: most samples follow in a few distances.
  struct Step {
    std::int64_t dt_ns = 0;  // 0: none
    std::complex<double> drive;
    std::array<std::complex<double>, kMaxModes> modes;
  };
  void evaluate(std::int64_t t_ns) noexcept;
  void turn_by(std::int64_t dt_ns) noexcept;
  void turn_to(std::int64_t t_ns) noexcept;

  int harmonics_;
  Eigen::Index steady_;
  std::size_t count_ = 0;  // of modes
  std::vector<std::complex<double>> poles_;
  std::vector<double> sizes_;
  std::vector<std::int64_t> faded_ns_;
  double omega_ = 0.0, rate_ = 0.0;
  std::int64_t t0_ns_ = 0, evaluated_ns_ = INT64_MIN;
  std::complex<double> drive_turn_;
  std::array<std::complex<double>, kMaxModes> turns_{};  // exp(λ_m u)
  std::array<Step, 4> steps_;
  std::size_t next_step_ = 0;
  int steps_taken_ = 0;  // since the turns were computed anew
  Eigen::VectorXd x_;
};

}  // namespace dwell
