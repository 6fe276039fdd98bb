// Estimates all elements from the phasors of all channels, with uncertainty by the GUM's law of propagation.
//
// The steps, each with a file of its own (docs/method.md, Identification and Uncertainty):
//
//   evidence.hpp       input: phasors of each channel and the frequency, with their uncertainties
//   observed.hpp       divides the transducers out: o, and x = gain·o
//   chain_state.hpp    force f_k, deformation d_k and Z_k = f_k/d_k of every element; c = Re Z, r = Im Z / ω
//   error_sources.hpp  all error sources, with the effect of one standard deviation
//   propagation.hpp    covariance and budget, to second order (GUM, JCGM 100, 5.1.2, note; JCGM 102)
//   passivity.hpp      withholds elements with a negative coefficient
//   linearity.hpp      warns of elements that are not linear, doubts them where a channel distorts
//
// An element is reported if |d_k| > 3 u(d_k) and u(Z_k) < |Z_k|/3. Otherwise it is withheld with the reason.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <string>
#include <vector>

#include "core/chain/evidence.hpp"
#include "core/chain/observed.hpp"
#include "core/chain/propagation.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct ElementsResult {
  std::vector<ElementEstimate> elements;  // one per element of the chain
  // Standard uncertainties of c and r of each element, N/m and N·s/m; NaN: the readings do not determine them. An
  // element whose coefficients come out negative is determined, although it is withheld.
  std::vector<Eigen::Vector2d> u;
  std::vector<double> covariance;  // of (c, r) of each identifiable element; row-major
  std::vector<Warning> warnings;
  std::vector<Doubt> doubts;
  std::vector<std::complex<double>> Z;  // N/m; NaN where not determined
  std::vector<SourceEffect> effects;    // the covariance source by source, for numbers derived from coefficients
  Eigen::MatrixXcd by_channel;          // elements × channels: δZ per relative change of a channel's phasor
  Eigen::MatrixXd gain;                 // x = gain·o (core/rig/observation.hpp)
  Eigen::VectorXcd Y, d;                // phasors Y_0 … Y_n, and deformation of every element
};

// gain: of the usable channels alone. evidence: one per Rig::channels. Allocates; O(sources · elements²).
[[nodiscard]] ElementsResult estimate_elements(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence,
                                               const Frequency& frequency);

}  // namespace dwell
