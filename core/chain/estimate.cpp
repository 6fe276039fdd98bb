#include "core/chain/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/complex.hpp"
#include "core/chain/chain_state.hpp"
#include "core/chain/error_sources.hpp"
#include "core/chain/identify.hpp"
#include "core/chain/linearity.hpp"
#include "core/chain/passivity.hpp"

namespace dwell {
namespace {

using Eigen::MatrixXcd;
using Eigen::VectorXcd;
using Index = Eigen::Index;

// Per element and channel: whether the element's force or deformation depends on the channel.
std::vector<std::vector<bool>> channels_used(const Gain& gain, const ElementStates& elements) {
  std::vector<std::vector<bool>> used(static_cast<std::size_t>(elements.Z.size()));
  for (Index e = 0; e < elements.Z.size(); ++e)
    for (Index c = 0; c < gain.gain.cols(); ++c)
      used[static_cast<std::size_t>(e)].push_back(gain.uses(elements.force_rows.row(e).transpose(), c) ||
                                                  gain.uses(elements.deformation_rows.row(e).transpose(), c));
  return used;
}

std::string missing_channels(const Rig& rig, const std::vector<Evidence>& evidence) {
  std::string out;
  for (std::size_t c = 0; c < evidence.size(); ++c)
    if (!evidence[c].usable && rig.channels[c].measures != Quantity::auxiliary)
      out += (out.empty() ? "" : "; ") + rig.channels[c].name + ": " + evidence[c].reason;
  return out;
}

}  // namespace

ElementsResult estimate_elements(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence,
                                 const Frequency& frequency) {
  const int n = rig.mass_count();
  const auto elements = static_cast<Index>(rig.element_count());
  const auto channels = static_cast<Index>(rig.channels.size());
  VectorXcd o = VectorXcd::Zero(channels);
  for (Index c = 0; c < channels; ++c) {
    const Evidence& seen = evidence[static_cast<std::size_t>(c)];
    if (seen.usable) o(c) = as_observed(rig, static_cast<int>(c), seen.X[0], frequency.omega, 1);
  }
  const ChainState chain{rig, n, frequency.omega, gain.gain * o};
  const ElementStates states(chain);

  Propagation propagation(chain, states);
  MatrixXcd x_per_reading = gain.gain.cast<Complex>();
  for (Index c = 0; c < channels; ++c)
    x_per_reading.col(c) *= as_observed(rig, static_cast<int>(c), 1.0, frequency.omega, 1);
  propagation.set_scatter(x_per_reading, evidence);
  for (const ErrorSource& source : sources_of(gain, evidence, o, chain, states, frequency)) propagation.add(source);
  propagation.add_second_order();

  ElementsResult result;
  const std::string missing = missing_channels(rig, evidence);
  for (Index e = 0; e < elements; ++e) {
    ElementEstimate element;
    element.k = static_cast<int>(e) + 1;
    Complex Z = states.Z(e);
    if (!gain.determines(states.force_rows.row(e).transpose()) ||
        !gain.determines(states.deformation_rows.row(e).transpose())) {
      element.reason = missing.empty() ? "the channels present do not determine it" : missing;
      Z = Complex{kNaN, kNaN};
    } else {
      element.deformation = {std::abs(states.d(e)), propagation.deformation_u(e)};
      const Coefficient c = propagation.coefficient(2 * e, stiffness(Z));
      const Coefficient r = propagation.coefficient(2 * e + 1, damping(Z, frequency.omega));
      const double u_Z = std::hypot(c.u, frequency.omega * r.u);
      if (!(element.deformation.value > 3 * element.deformation.u)) {
        element.reason = "its deformation is too small to measure: |d| is not above 3 u(d)";
      } else if (!(u_Z < std::abs(Z) / 3)) {
        element.reason = "its force is not resolved: u(Z) is above |Z|/3";
        if (const std::vector<BudgetShare> budget = propagation.budget(e); !budget.empty())
          element.reason += "; the largest source is " + budget.front().source;
      } else {
        element.identifiable = true;
        element.stiffness = c;
        element.damping = r;
        const double eta = frequency.omega * r.value / c.value;
        const Eigen::MatrixXd& C = propagation.covariance();
        const double variance = C(2 * e + 1, 2 * e + 1) / (r.value * r.value) + C(2 * e, 2 * e) / (c.value * c.value) -
                                2 * C(2 * e, 2 * e + 1) / (r.value * c.value);
        element.loss_factor = {eta, std::abs(eta) * std::sqrt(std::max(0.0, variance))};
        element.budget = propagation.budget(e);
      }
    }
    result.u.emplace_back(element.identifiable ? Eigen::Vector2d(element.stiffness.u, element.damping.u)
                                               : Eigen::Vector2d::Constant(kNaN));
    result.elements.push_back(std::move(element));
    result.Z.push_back(Z);
  }
  refuse_negative(rig, channels_used(gain, states), result.elements, result.doubts);
  Linearity linearity = judge_linearity(rig, gain, evidence, frequency, result.elements);
  result.warnings = std::move(linearity.warnings);
  for (Doubt& doubt : linearity.doubts) result.doubts.push_back(std::move(doubt));
  std::vector<Index> rows;
  for (Index e = 0; e < elements; ++e)
    if (result.elements[static_cast<std::size_t>(e)].identifiable) rows.insert(rows.end(), {2 * e, 2 * e + 1});
  result.effects = std::move(propagation.effects());
  result.by_channel.resize(elements, channels);
  for (Index c = 0; c < channels; ++c) result.by_channel.col(c) = propagation.on_Z(gain.gain.col(c) * o(c));
  result.gain = gain.gain;
  result.Y.resize(n + 1);
  for (int k = 0; k <= n; ++k) result.Y(k) = chain.Y(k);
  result.d = states.d;
  for (const Index i : rows)
    for (const Index j : rows) result.covariance.push_back(propagation.covariance()(i, j));
  return result;
}

}  // namespace dwell
