#include "core/transient/modal_regressors.hpp"

#include <algorithm>

#include "core/base/complex.hpp"

namespace dwell {

ModalRegressors::ModalRegressors(int harmonics, int modes)
    : motion_(modes), layout_{harmonics, 0}, faded_ns_(motion_.capacity(), INT64_MAX) {
  x_.resize(ModalLayout{harmonics, static_cast<Eigen::Index>(motion_.capacity())}.all());
}

void ModalRegressors::restart(double omega, double rate, std::int64_t t0_ns, std::span<const Complex> poles) noexcept {
  motion_.restart(omega, rate, t0_ns, poles);
  turns_.restart();
  layout_.modes = static_cast<Eigen::Index>(motion_.count());
  std::fill(faded_ns_.begin(), faded_ns_.end(), INT64_MAX);
}

const Eigen::VectorXd& ModalRegressors::at(std::int64_t t_ns) noexcept {
  if (t_ns == turns_.at_ns()) return x_;
  ++computed_;
  turns_.go(motion_, t_ns);
  const double u = motion_.seconds(t_ns);
  const int harmonics = layout_.harmonics;
  const Complex drive = turns_.drive();
  Complex turn = drive;
  x_(0) = 1.0;
  for (int h = 1; h <= harmonics; ++h, turn *= drive) {
    x_(layout_.sine(h)) = turn.imag();
    x_(layout_.cosine(h)) = turn.real();
  }
  for (std::size_t m = 0; m < motion_.count(); ++m) {
    const auto mode = static_cast<Eigen::Index>(m);
    const Eigen::Index i = layout_.amplitude(mode), d = layout_.by_pole(mode);
    if (t_ns >= faded_ns_[m]) {
      x_.segment<2>(i).setZero();
      x_.segment<2>(d).setZero();
      continue;
    }
    const double slope = motion_.size(m) * u;
    x_(i) = turns_.mode(m).real();
    x_(i + 1) = -turns_.mode(m).imag();
    x_(d) = slope * x_(i);
    x_(d + 1) = slope * x_(i + 1);
  }
  // Derivatives by ω: only of the fundamental, which tells most of ω.
  const Eigen::Index w = layout_.by_omega();
  x_(w) = motion_.omega() * u * x_(layout_.sine(1));
  x_(w + 1) = motion_.omega() * u * x_(layout_.cosine(1));
  return x_;
}

}  // namespace dwell
