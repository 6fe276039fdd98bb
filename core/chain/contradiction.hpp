// Finds redundant transducers that contradict each other, by the residuals o - G x of the least-squares solution x.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/chain/estimate.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// At most one doubt. It names the channels with a residual above five standard deviations (noise, scales, delays,
// filters) and the elements computed from these. G: observation_matrix(rig); omega: rad/s. Allocates.
[[nodiscard]] std::vector<Doubt> contradictions(const Rig& rig, const Eigen::MatrixXd& G, const Gain& gain,
                                                const std::vector<Evidence>& evidence, double omega);

}  // namespace dwell
