// The Cramér-Rao bound of the harmonic-only model for the coefficients of a case, written from the method page's
// sections 5 and 7 with the true phasors; it shares nothing with core/chain/estimate.cpp.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

struct ElementBound {
  Complex Z;             // true, N/m
  Complex d;             // true deformation, m
  double sigma_d = 0.0;  // standard deviation of each component of d
  double sigma_Z = 0.0;  // of each component of Z: of c, and of ωr
};

// What the readings' phasors X at one frequency say of each element: force X, deformation X. Elements × channels.
struct ElementRows {
  Eigen::MatrixXcd force, deformation;
};
// Of the rig as it truly is, its transducers' gain, delay and filter divided out.
[[nodiscard]] ElementRows true_rows(const Case& about, double omega);

// For white noise over `seconds`, so many periods that the regressors are orthogonal: 2σ²/N on each component of a
// phasor. Noise: Line::noise().
[[nodiscard]] std::vector<ElementBound> bounds_of(const Case& about, double seconds);

// Z of every element from readings taken as they come: masses and places as stated, no response of a transducer divided
// out.
[[nodiscard]] std::vector<Complex> stiffness_of(const Case& about, double omega, const std::vector<Complex>& X);

}  // namespace dwell::study
