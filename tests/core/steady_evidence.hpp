// What the transducers of a rig read of a chain in its steady state, for tests of the estimate.
#pragma once

#include <vector>

#include "core/chain/chain_state.hpp"
#include "core/chain/evidence.hpp"
#include "core/chain/observed.hpp"
#include "core/model/forward.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// X_1 of every channel, exact, the table moving by 2 mm; 1000 degrees of freedom behind a noise of zero.
inline std::vector<Evidence> steady_evidence(const Chain& chain, const Rig& rig, double omega) {
  std::vector<Evidence> out(rig.channels.size());
  const SteadyResponse steady = steady_response(chain, omega, 0.002);
  for (std::size_t c = 0; c < out.size(); ++c) {
    const Channel& channel = rig.channels[c];
    std::complex<double> y = channel.measures == Quantity::force ? steady.F
                             : channel.at == kGround             ? 0.0
                                                                 : steady.Y[static_cast<std::size_t>(channel.at)];
    if (channel.relative_to) y -= steady.Y[static_cast<std::size_t>(*channel.relative_to)];
    out[c].usable = true;
    out[c].X[0] = y / as_observed(rig, static_cast<int>(c), 1.0, omega, 1);
    out[c].dof = 1000;
  }
  return out;
}

// o of every channel; 0 where it is not usable.
inline Eigen::VectorXcd observed_by(const Rig& rig, const std::vector<Evidence>& evidence, double omega) {
  Eigen::VectorXcd o = Eigen::VectorXcd::Zero(static_cast<Eigen::Index>(evidence.size()));
  for (std::size_t c = 0; c < evidence.size(); ++c)
    if (evidence[c].usable)
      o(static_cast<Eigen::Index>(c)) = as_observed(rig, static_cast<int>(c), evidence[c].X[0], omega, 1);
  return o;
}

}  // namespace dwell
