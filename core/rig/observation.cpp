#include "core/rig/observation.hpp"

#include <Eigen/QR>
#include <cmath>

#include "core/base/rounding.hpp"

namespace dwell {
namespace {

// A number up to this is rounding of a zero: an entry of `null_projector` or `gain` (0 or of order 1), or a sum
// relative to its terms. A redundant transducer with 1e9 times the variance of the others therefore counts as unused.

// Whether function·column is zero apart from rounding, relative to the sum of the absolute terms.
bool vanishes(const Eigen::Ref<const Eigen::VectorXcd>& function, const Eigen::Ref<const Eigen::VectorXd>& column) {
  std::complex<double> sum = 0.0;
  double terms = 0.0;
  for (Eigen::Index l = 0; l < column.size(); ++l) {
    if (std::abs(column(l)) <= kOnlyRounding) continue;
    sum += function(l) * column(l);
    terms += std::abs(function(l) * column(l));
  }
  return std::abs(sum) <= kOnlyRounding * terms;
}

}  // namespace

bool Gain::determines(const Eigen::Ref<const Eigen::VectorXcd>& function) const {
  if (function.isZero(0)) return false;
  for (Eigen::Index j = 0; j < null_projector.cols(); ++j)
    if (!vanishes(function, null_projector.col(j))) return false;
  return true;
}

bool Gain::uses(const Eigen::Ref<const Eigen::VectorXcd>& function, Eigen::Index channel) const {
  return !vanishes(function, gain.col(channel));
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
  result.null_projector = Eigen::MatrixXd::Identity(G.cols(), G.cols()) - result.gain * G;
  return result;
}

}  // namespace dwell
