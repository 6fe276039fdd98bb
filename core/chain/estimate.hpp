// From the phasors of all channels to the elements, with uncertainty by the GUM's law of propagation.
//
// The steps, each with a file of its own (docs/method.md, Identification and Uncertainty):
//
//   evidence.hpp       what is known of each channel and of the frequency
//   observed.hpp       its transducers divided out: o, and x = gain·o
//   chain_state.hpp    force f_k, deformation d_k and Z_k = f_k/d_k of every element; c = Re Z, r = Im Z / ω
//   error_sources.hpp  every source of error, and what one standard deviation of it does
//   propagation.hpp    covariance and budget from these, to second order (GUM, JCGM 100, 5.1.2, note; JCGM 102)
//   passivity.hpp, linearity.hpp  which elements are doubted although they are resolved
//
// An element is reported where |d_k| > 3 u(d_k) and u(Z_k) < |Z_k|/3, else withheld with the reason.
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
  std::vector<double> covariance;         // row-major, of [c, r] of the identifiable ones
  std::vector<std::string> warnings;
  std::vector<Doubt> doubts;
  std::vector<std::complex<double>> Z;  // N/m; NaN where not determined
  std::vector<SourceEffect> effects;    // the covariance source by source, for what is derived from the coefficients
  Eigen::MatrixXcd by_channel;          // elements × channels: δZ by a relative change of a channel's phasor
  Eigen::MatrixXd gain;                 // x by what the channels observe (core/rig/observation.hpp)
  Eigen::VectorXcd Y, d;                // phasors of Y_0 … Y_n and of the deformation of every element
};

// All elements. gain: for the channels that are usable. Allocates; O(sources · elements²).
[[nodiscard]] ElementsResult estimate_elements(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence,
                                               const Frequency& frequency);

}  // namespace dwell
