// What is known of the transient and of steady lines is subtracted from the readings that count. What is not known of
// them stays in the phasors as an uncertainty, by the overlap of the modes with sine and cosine.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/transient/hold_fit.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor.
class TransientRemoval {
 public:
  // rig and fit must outlive this.
  TransientRemoval(const Rig& rig, HoldFit& fit);

  // Subtracts nothing more.
  void stop() noexcept { until_ns_.reset(); }
  // Subtracts from readings from from_ns on: until each mode has become negligible, and at least until until_ns. The
  // overlap is counted anew. fit: its poles' errors propagated.
  void begin(std::int64_t from_ns, std::int64_t until_ns) noexcept;
  // Whether the readings that count are those without the transient.
  [[nodiscard]] bool active() const noexcept { return until_ns_.has_value(); }

  // A reading without what is known of the transient. Each reading that counts once, since begin(). Real-time safe.
  [[nodiscard]] double clean(int channel, std::int64_t t_ns, double value) noexcept;
  // Covariance of (p_1, q_1) over so many readings, by what is not known of what was subtracted; referred to the fit's
  // zero of time.
  [[nodiscard]] Eigen::Matrix2d covariance(int channel, double samples) const noexcept;
  // (Σ sin ωu e, Σ cos ωu e), e what was subtracted.
  [[nodiscard]] Eigen::Vector2d taken_out(int channel) const noexcept;

 private:
  // What may be left in a channel without being subtracted, its unit.
  [[nodiscard]] double negligible(int channel) const noexcept;
  void fade_modes(std::int64_t from_ns) noexcept;

  const Rig& rig_;
  HoldFit& fit_;
  std::optional<std::int64_t> until_ns_;  // of readings; empty: nothing is subtracted
  // Per channel Σ (sin, cos)' (modes): what an error of the modes' amplitudes does to the steady phasor.
  std::vector<Eigen::Matrix<double, 2, Eigen::Dynamic>> overlap_;
};

}  // namespace dwell
