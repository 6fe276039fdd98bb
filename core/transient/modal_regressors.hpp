// Computes the regressors of the modal fit at an instant, in the order of ModalLayout. Faded modes are skipped.
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

  // Changes the motion, see ModalMotion::restart. None of the new modes has faded.
  void restart(double omega, double rate, std::int64_t t0_ns, std::span<const std::complex<double>> poles) noexcept;
  [[nodiscard]] const ModalMotion& motion() const noexcept { return motion_; }
  [[nodiscard]] const ModalLayout& layout() const noexcept { return layout_; }

  // The regressors at t, until the next call: the first layout().all() elements count. O(H + modes).
  [[nodiscard]] const Eigen::VectorXd& at(std::int64_t t_ns) noexcept;
  // How often at() computed anew. While the count stays, at() gives the same numbers, bit for bit.
  [[nodiscard]] std::uint64_t computed() const noexcept { return computed_; }

  // Sets the regressors of mode m to zero from t on, until the next restart.
  void fade(std::size_t m, std::int64_t t_ns) noexcept { faded_ns_[m] = t_ns; }
  // The instant given to fade(); INT64_MAX: the mode has not faded.
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
