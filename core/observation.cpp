#include "core/observation.hpp"

#include <Eigen/QR>
#include <cmath>

namespace dwell {

bool Gain::determines(const Eigen::Ref<const Eigen::VectorXcd>& function) const {
  const double size = function.norm();
  return size > 0 && (function.transpose() * unresolved).norm() <= 1e-9 * size;
}

Eigen::MatrixXd observation_matrix(const Rig& rig) {
  const int n = rig.mass_count();
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rig.channels.size()), n + 2);
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    const Channel& channel = rig.channels[c];
    const auto row = static_cast<Eigen::Index>(c);
    if (channel.measures == Quantity::auxiliary) continue;
    if (channel.measures == Quantity::force) {
      G(row, n + 1) = 1.0;
      continue;
    }
    const auto add_position = [&](int place, double sign) {
      if (place == kGround) return;  // the ground does not move
      for (int l = 0; l <= place; ++l) G(row, l) += sign;
    };
    add_position(channel.at, 1.0);
    if (channel.relative_to) add_position(*channel.relative_to, -1.0);
  }
  return G;
}

Gain solve_observation(const Eigen::MatrixXd& G, const Eigen::VectorXd& weights) {
  const Eigen::MatrixXd weighted = weights.asDiagonal() * G;
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition(weighted);
  Gain result;
  result.gain = decomposition.pseudoInverse() * weights.asDiagonal();
  result.unresolved = Eigen::MatrixXd::Identity(G.cols(), G.cols()) - result.gain * G;
  return result;
}

}  // namespace dwell
