// The order of the regressors in the vector x of the modal fit.
//
//   1, sin hωu, cos hωu (h = 1 … H)                            harmonic(): 2H+1
//   each mode: Re and Im of its amplitude                      modal(): two a mode, from amplitude(m) on
//   each mode: derivatives by its pole's relative change       two a mode (Re, Im), from by_pole(m) on
//   the fundamental: derivatives by the relative change of ω   two, from by_omega() on
//
// The first two rows belong to the linear parameters of the fit. The derivatives serve to improve the poles and ω.
#pragma once

#include <Eigen/Core>

namespace dwell {

struct ModalLayout {
  int harmonics = 0;
  Eigen::Index modes = 0;

  [[nodiscard]] Eigen::Index harmonic() const noexcept { return 2 * harmonics + 1; }
  [[nodiscard]] Eigen::Index modal() const noexcept { return 2 * modes; }
  [[nodiscard]] Eigen::Index linear() const noexcept { return harmonic() + modal(); }
  [[nodiscard]] Eigen::Index slopes() const noexcept { return modal() + 2; }
  [[nodiscard]] Eigen::Index all() const noexcept { return linear() + slopes(); }

  [[nodiscard]] Eigen::Index sine(int h) const noexcept { return h; }
  [[nodiscard]] Eigen::Index cosine(int h) const noexcept { return harmonics + h; }
  [[nodiscard]] Eigen::Index amplitude(Eigen::Index m) const noexcept { return harmonic() + 2 * m; }
  [[nodiscard]] Eigen::Index by_pole(Eigen::Index m) const noexcept { return linear() + 2 * m; }
  [[nodiscard]] Eigen::Index by_omega() const noexcept { return linear() + modal(); }
};

}  // namespace dwell
