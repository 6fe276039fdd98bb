#include "core/transient/modal_regressors.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

using Eigen::Index;

constexpr double kSecondPerNs = 1e-9;
constexpr double kFaded = 1e-13;   // of an amplitude: as good as nothing
constexpr int kTurnsInARow = 256;  // from turn to turn: their rounding stays below 1e-13

}  // namespace

ModalRegressors::ModalRegressors(int harmonics, int modes)
    : harmonics_(harmonics),
      steady_(2 * harmonics + 1),
      poles_(static_cast<std::size_t>(std::min(modes, kMaxModes))),
      sizes_(poles_.size()),
      faded_ns_(poles_.size(), INT64_MAX) {
  x_.resize(steady_ + 4 * static_cast<Index>(poles_.size()) + 2);
}

void ModalRegressors::restart(double omega, double rate, std::int64_t t0_ns, std::span<const Complex> poles) noexcept {
  omega_ = omega;
  rate_ = rate;
  t0_ns_ = t0_ns;
  evaluated_ns_ = INT64_MIN;
  for (Step& step : steps_) step.dt_ns = 0;
  count_ = std::min(poles.size(), capacity());
  if (poles.data() != poles_.data()) std::copy_n(poles.begin(), count_, poles_.begin());
  for (std::size_t m = 0; m < count_; ++m) sizes_[m] = std::abs(poles_[m]);
  std::fill(faded_ns_.begin(), faded_ns_.end(), INT64_MAX);
}

double ModalRegressors::angle(std::int64_t t_ns) const noexcept {
  const double u = kSecondPerNs * static_cast<double>(t_ns - t0_ns_);
  return (omega_ + 0.5 * rate_ * u) * u;
}

void ModalRegressors::turn_to(std::int64_t t_ns) noexcept {
  const double u = kSecondPerNs * static_cast<double>(t_ns - t0_ns_);
  drive_turn_ = std::polar(1.0, omega_ * u);
  for (std::size_t m = 0; m < count_; ++m) {
    const double envelope = std::exp(poles_[m].real() * u);
    turns_[m] = envelope < kFaded ? Complex{} : std::polar(envelope, poles_[m].imag() * u);
  }
  steps_taken_ = 0;
}

void ModalRegressors::turn_by(std::int64_t dt_ns) noexcept {
  auto step = std::find_if(steps_.begin(), steps_.end(), [&](const Step& each) { return each.dt_ns == dt_ns; });
  if (step == steps_.end()) {
    step = steps_.begin() + static_cast<std::ptrdiff_t>(next_step_++ % steps_.size());
    const double dt_s = kSecondPerNs * static_cast<double>(dt_ns);
    step->dt_ns = dt_ns;
    step->drive = std::polar(1.0, omega_ * dt_s);
    for (std::size_t m = 0; m < count_; ++m)
      step->modes[m] = std::polar(std::exp(poles_[m].real() * dt_s), poles_[m].imag() * dt_s);
  }
  // By hand: std::complex multiplies with care for infinities.
  const auto times = [](Complex a, Complex b) {
    return Complex{a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
  };
  drive_turn_ = times(drive_turn_, step->drive);
  for (std::size_t m = 0; m < count_; ++m) {
    turns_[m] = times(turns_[m], step->modes[m]);
    if (std::norm(turns_[m]) < kFaded * kFaded) turns_[m] = {};
  }
  ++steps_taken_;
}

void ModalRegressors::evaluate(std::int64_t t_ns) noexcept {
  if (t_ns > evaluated_ns_ && evaluated_ns_ >= t0_ns_ && steps_taken_ < kTurnsInARow)
    turn_by(t_ns - evaluated_ns_);
  else
    turn_to(t_ns);
  if (rate_ != 0) drive_turn_ = std::polar(1.0, angle(t_ns));
  evaluated_ns_ = t_ns;
  const double u = kSecondPerNs * static_cast<double>(t_ns - t0_ns_);
  Complex turn = drive_turn_;
  x_(0) = 1.0;
  for (int h = 1; h <= harmonics_; ++h, turn *= drive_turn_) {
    x_(h) = turn.imag();
    x_(harmonics_ + h) = turn.real();
  }
  for (std::size_t m = 0; m < count_; ++m) {
    const Index i = steady_ + 2 * static_cast<Index>(m);
    if (t_ns >= faded_ns_[m]) {
      x_.segment<2>(i).setZero();
      x_.segment<2>(modal() + i).setZero();
      continue;
    }
    const double slope = sizes_[m] * u;
    x_(i) = turns_[m].real();
    x_(i + 1) = -turns_[m].imag();
    x_(modal() + i) = slope * x_(i);
    x_(modal() + i + 1) = slope * x_(i + 1);
  }
  const Index w = linear() + modal();
  x_(w) = omega_ * u * x_(1);
  x_(w + 1) = omega_ * u * x_(harmonics_ + 1);
}

}  // namespace dwell
