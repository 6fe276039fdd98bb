// exp(jωu) of the drive and exp(λu) of the modes, from instant to instant.
//
// Most samples follow in a few distances: what these turn by is kept, so that a step costs a multiplication for each
// mode and no sine.
//
// Fixed storage, no allocation. Bound to one thread; real-time safe.
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>

#include "core/transient/modal_motion.hpp"

namespace dwell {

class ModalTurns {
 public:
  // Of another motion from now on.
  void restart() noexcept;
  // Goes to t. Instants that grow are cheapest.
  void go(const ModalMotion& motion, std::int64_t t_ns) noexcept;

  // Where it is; INT64_MIN: nowhere yet.
  [[nodiscard]] std::int64_t at_ns() const noexcept { return at_ns_; }
  [[nodiscard]] std::complex<double> drive() const noexcept { return drive_; }
  [[nodiscard]] std::complex<double> mode(std::size_t m) const noexcept { return modes_[m]; }

 private:
  using Modes = std::array<std::complex<double>, ModalMotion::kMaxModes>;
  struct Step {
    std::int64_t dt_ns = 0;  // 0: none
    std::complex<double> drive;
    Modes modes;
  };
  void turn_by(const ModalMotion& motion, std::int64_t dt_ns) noexcept;
  void turn_to(const ModalMotion& motion, std::int64_t t_ns) noexcept;

  std::int64_t at_ns_ = INT64_MIN;
  std::complex<double> drive_;
  Modes modes_{};
  std::array<Step, 4> steps_;
  std::size_t next_step_ = 0;
  int taken_ = 0;  // steps since the turns were computed anew
};

}  // namespace dwell
