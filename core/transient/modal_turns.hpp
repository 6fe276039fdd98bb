// Computes exp(jωu) of the drive and exp(λu) of the modes from one sample's instant to the next.
//
// Most distances between samples repeat. The factors of four distances are kept, so that a step costs one
// multiplication per mode and no sine.
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
  // Call after the motion has changed: forgets the kept factors.
  void restart() noexcept;
  // Computes drive() and mode() at t. Increasing instants are cheapest.
  void go(const ModalMotion& motion, std::int64_t t_ns) noexcept;

  // The instant of the last go(), for which drive() and mode() hold; INT64_MIN: none since restart().
  [[nodiscard]] std::int64_t at_ns() const noexcept { return at_ns_; }
  [[nodiscard]] std::complex<double> drive() const noexcept { return drive_; }
  [[nodiscard]] std::complex<double> mode(std::size_t m) const noexcept { return modes_[m]; }

 private:
  using Modes = std::array<std::complex<double>, ModalMotion::kMaxModes>;
  struct Step {
    std::int64_t dt_ns = 0;  // 0: unused
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
  int taken_ = 0;  // steps since drive_ and modes_ were computed directly
};

}  // namespace dwell
