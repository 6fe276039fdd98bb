// How far a disturbance moves what a plain fit of harmonics would give, and what could tell that it does: the ground on
// which a dwell of the population `disturbed` is judged. Shares nothing with core but the eigenvalues of a chain.
#pragma once

#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

struct Moved {
  // Per element: shift of c and of ωr over the uncertainty that a healthy dwell would state.
  std::vector<double> c, r;
  std::vector<bool> stands_out;  // |d| and |Z| exceed six standard deviations
  // How well the fault of a model shows: shift of a pole over what the transient resolves, or the third harmonic of an
  // element's force over its standard deviation; the largest of all. ∞ where the model is not at fault.
  double shows = INFINITY;
  // The same with what the identified chain's own uncertainty leaves open of its poles beside it.
  double surely = INFINITY;
  // It shows by the transient: a dwell that began before there was one cannot tell.
  bool by_transient = false;
  // No coefficient that stands out moves by one standard uncertainty; and there is one.
  [[nodiscard]] bool harmless() const;
};
// A fault of the model counts where it shows by this: it is resolved to a fifth.
inline constexpr double kShows = 5.0;

// A dwell whose data count from `from_s` on for `seconds`. The shift: harmonics fitted to the disturbed readings
// without noise and without transient, at the stamps and the frequency that the rig file makes one believe. The
// uncertainty: the Cramér-Rao bound, and what is stated of frequency, clock and instants. What the transient resolves:
// the Cramér-Rao bound of the poles, with the amplitudes of all modes and harmonics in all channels unknown beside
// them.
[[nodiscard]] Moved moved_by(const Case& about, double from_s, double seconds);

// Standard deviations of the real and the imaginary part of each pole (Motion::natural()), 1/s: what the transient from
// the newest drive's start to `end_s` tells at best.
[[nodiscard]] std::vector<Complex> resolved_poles(const Case& about, double end_s);

}  // namespace dwell::study
