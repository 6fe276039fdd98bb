// Subtracts the transient and the steady lines, as fitted, from the readings that count. Their uncertainty stays in the
// phasors, by the overlap of the modes with sine and cosine.
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

  // Ends the subtraction.
  void stop() noexcept { until_ns_.reset(); }
  // Subtracts from readings from from_ns on, until each mode has become negligible and at least until until_ns. Clears
  // the overlap. The errors of the fit's poles must have been propagated.
  void begin(std::int64_t from_ns, std::int64_t until_ns) noexcept;
  // Whether the readings that count are cleaned: begin() was called since stop().
  [[nodiscard]] bool active() const noexcept { return until_ns_.has_value(); }

  // The transient and the steady lines at t, in the channel's unit; 0 where nothing is subtracted. Real-time safe.
  [[nodiscard]] double transient(int channel, std::int64_t t_ns) noexcept;
  // A reading less the transient and the steady lines. Once for each reading that counts since begin(). Real-time safe.
  [[nodiscard]] double clean(int channel, std::int64_t t_ns, double value) noexcept;
  // Covariance of (p_1, q_1) over so many readings, by the error of what was subtracted. Zero of time: the fit's t_0.
  [[nodiscard]] Eigen::Matrix2d covariance(int channel, double samples) const noexcept;
  // (Σ sin ωu e, Σ cos ωu e), e what was subtracted from a reading.
  [[nodiscard]] Eigen::Vector2d taken_out(int channel) const noexcept;

 private:
  // Amplitude below which a mode need not be subtracted from a channel, its unit.
  [[nodiscard]] double negligible(int channel) const noexcept;
  void fade_modes(std::int64_t from_ns) noexcept;

  const Rig& rig_;
  HoldFit& fit_;
  std::optional<std::int64_t> until_ns_;  // end of the subtraction; empty: nothing is subtracted
  // Per channel, ModalFit::overlap_at summed: turns errors of the modes' amplitudes into errors of the steady phasor.
  std::vector<Eigen::Matrix<double, 2, Eigen::Dynamic>> overlap_;
};

}  // namespace dwell
