// Coefficients of a first look, without state, initial condition or steady motion: the weak form of the equations.
//
// For a test function χ that vanishes with its first five derivatives at the ends of a window, four integrations by
// parts of the equations of the masses k … n, added up, give
//
//   Σ_{i>=k} m_i ∫χ'''' y_i + ∫χ'' F = -c_k ∫χ'' d_k + r_k ∫χ''' d_k ,   element n+1: ∫χ'' F = c ∫χ'' y_n - r ∫χ''' y_n
//
// (free: no F), linear in c_k and r_k: one row per window, least squares over all windows. A transducer of velocity or
// acceleration has its integrals with one or two derivatives of χ less. χ = (1 - u²)⁶; the integrals are those of a
// cubic through the nearest four readings, since the trapezoid rule on irregular instants errs by (ωΔt)²/12.
// A window with a gap in its readings is left out. Noise in d_k makes both coefficients too small: good to start from,
// not to report. Filters count at the nominal drive alone. docs/method.md, Any motion.
#pragma once

#include <Eigen/Core>

#include "core/motion/likelihood.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct WeakForm {
  Eigen::VectorXd stiffness, damping;  // per element; NaN where the channels do not determine it or no window fits
  // Per element, 0 … 1: the part of Σ left² that its coefficients explain, γ² of modal testing; NaN as above. The
  // coefficients are H1, too small by noise in d. Divided by γ² they are H2, too large by noise in the left side.
  // Source: J. S. Bendat, A. G. Piersol, Random Data: frequency response with noise at input and output.
  Eigen::VectorXd coherence;
};

// data: by time, of all channels that count. Allocates; thread-safe. O(readings).
[[nodiscard]] WeakForm weak_form(const Rig& rig, const MotionData& data);

}  // namespace dwell
