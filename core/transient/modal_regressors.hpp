// The regressors of the modal fit at an instant, as ModalLayout orders them. A mode that has faded costs no more.
//
// All memory is allocated by the constructor. Bound to one thread; real-time safe.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transient/modal_layout.hpp"
#include "core/transient/modal_motion.hpp"
#include "core/transient/modal_turns.hpp"

namespace dwell {

class ModalRegressors {
 public:
  ModalRegressors(int harmonics, int modes);

  // Of another motion from now on, see ModalMotion::restart; none of its modes has faded.
  void restart(double omega, double rate, std::int64_t t0_ns, std::span<const std::complex<double>> poles) noexcept;
  [[nodiscard]] const ModalMotion& motion() const noexcept { return motion_; }
  [[nodiscard]] const ModalLayout& layout() const noexcept { return layout_; }

  // Those at t: the first layout().all() count. O(H + modes).
  [[nodiscard]] const Eigen::VectorXd& at(std::int64_t t_ns) noexcept;
  // How often they were computed: as long as it stays, at() gives the same numbers, bit for bit.
  [[nodiscard]] std::uint64_t computed() const noexcept { return computed_; }

  // From t on a mode's regressors are zero, until the next restart.
  void fade(std::size_t m, std::int64_t t_ns) noexcept { faded_ns_[m] = t_ns; }
  // Since when they are; INT64_MAX: they are not.
  [[nodiscard]] std::int64_t faded_ns(std::size_t m) const noexcept { return faded_ns_[m]; }

 private:
  ModalMotion motion_;
  ModalTurns turns_;
  ModalLayout layout_;
  std::vector<std::int64_t> faded_ns_;
  Eigen::VectorXd x_;
  std::uint64_t computed_ = 0;
};

}  // namespace dwell
