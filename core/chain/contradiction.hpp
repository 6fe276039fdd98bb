// Redundant transducers: whether what each reads agrees with what all of that motion say together.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/chain/estimate.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// At most one doubt: of the elements computed from the channels that differ from the weighted mean of all by more than
// five standard deviations of noise, scales, delays and filters explain. G: observation_matrix(rig). Allocates.
[[nodiscard]] std::vector<Doubt> contradictions(const Rig& rig, const Eigen::MatrixXd& G, const Gain& gain,
                                                const std::vector<Evidence>& evidence, double omega);

}  // namespace dwell
