#include "core/chain/propagation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/complex.hpp"
#include "core/base/student.hpp"
#include "core/chain/identify.hpp"

namespace dwell {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

Propagation::Propagation(const ChainState& chain, const ElementStates& elements)
    : chain_(chain), elements_(elements), relative_deformation_rows_(elements.deformation_rows) {
  const Index count = elements.Z.size();
  through_x_.resize(count, chain.n + 2);
  for (Index e = 0; e < count; ++e) {
    through_x_.row(e) = (elements.force_rows.row(e) - elements.Z(e) * elements.deformation_rows.row(e)) / elements.d(e);
    relative_deformation_rows_.row(e) /= elements.d(e);
  }
  covariance_ = Eigen::MatrixXd::Zero(2 * count, 2 * count);
  deformation_variance_ = VectorXd::Zero(count);
  scatter_.resize(static_cast<std::size_t>(count));
  second_.resize(static_cast<std::size_t>(count));
}

void Propagation::set_scatter(const MatrixXcd& per_reading, const std::vector<Evidence>& evidence) {
  std::vector<std::vector<PhasorStretch>> stretches;
  for (const Evidence& seen : evidence) stretches.push_back(seen.stretches);
  for (Index e = 0; e < through_x_.rows(); ++e)
    scatter_[static_cast<std::size_t>(e)] = scatter_of_sum((through_x_.row(e) * per_reading).transpose(), stretches);
}

void Propagation::add(const ErrorSource& source) {
  const double omega = chain_.omega;
  const Index count = through_x_.rows();
  VectorXd v(2 * count);
  for (Index e = 0; e < count; ++e) {
    const double widens = source.residual ? scatter_[static_cast<std::size_t>(e)].widens() : 1.0;
    const Complex dZ = through_x_.row(e).transpose().cwiseProduct(source.on_x).sum() + source.on_Z(e);
    v(2 * e) = dZ.real();
    v(2 * e + 1) = dZ.imag() / omega - damping(elements_.Z(e), omega) * source.on_omega / omega;
    v.segment<2>(2 * e) *= std::sqrt(widens);
    // Per component, as deformation_u() is compared with |d|.
    const Complex relative = relative_deformation_rows_.row(e).transpose().cwiseProduct(source.on_x).sum();
    deformation_variance_(e) += 0.5 * widens * std::norm(relative * elements_.d(e));
    const Complex bent =
        source.bends_x.size() > 0 ? through_x_.row(e).transpose().cwiseProduct(source.bends_x).sum() : 0.0;
    second_[static_cast<std::size_t>(e)].add(std::sqrt(widens) * dZ, std::sqrt(widens) * relative, bent);
  }
  v = v.unaryExpr([](double a) { return std::isfinite(a) ? a : 0.0; });  // elements not determined: left out later
  const double mass_u = source.mass > 0 ? chain_.rig.mass_u[static_cast<std::size_t>(source.mass - 1)] : 0.0;
  Contribution& of_name =
      add_effect(source.name, source.dof, {v, source.mass, mass_u, source.clock_u, source.readings});
  of_name.kind = source.kind;
  of_name.channel = source.channel;
  of_name.device = source.device;
  of_name.mass = source.mass;
  for (Index e = 0; e < count; ++e)
    if (const Scatter& scatter = scatter_[static_cast<std::size_t>(e)]; source.residual && scatter.shows())
      of_name.dof.segment<2>(2 * e).setConstant(scatter.dof);
}

void Propagation::add_second_order() {
  const Index count = through_x_.rows();
  for (Index e = 0; e < count; ++e) {
    const Eigen::Matrix2d product = second_[static_cast<std::size_t>(e)].mean_product();
    if (!product.allFinite()) continue;  // element not determined
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(product);
    for (Index axis = 0; axis < 2; ++axis) {
      VectorXd v = VectorXd::Zero(2 * count);
      v.segment<2>(2 * e) = axes.eigenvectors().col(axis) * std::sqrt(std::max(0.0, axes.eigenvalues()(axis)));
      v(2 * e + 1) /= chain_.omega;
      add_effect("errors to second order", std::numeric_limits<double>::infinity(), {v, 0, 0.0, 0.0, {}}).kind =
          SourceKind::second_order;
    }
  }
}

double Propagation::deformation_u(Index e) const { return std::sqrt(deformation_variance_(e)); }

Coefficient Propagation::coefficient(Index i, double value) const {
  Coefficient out;
  out.value = value;
  const double variance = covariance_(i, i);
  out.u = std::sqrt(variance);
  double shares = 0.0;  // Σ u_i⁴ / ν_i
  for (const auto& [name, part] : by_name_) shares += part.variance(i) * part.variance(i) / part.dof(i);
  out.dof = shares > 0 ? variance * variance / shares : std::numeric_limits<double>::infinity();
  out.U95 = student_t95(out.dof) * out.u;
  out.significant = std::abs(value) >= out.u;
  return out;
}

std::vector<BudgetShare> Propagation::budget(Index e) const {
  std::vector<BudgetShare> out;
  const double c = covariance_(2 * e, 2 * e), r = covariance_(2 * e + 1, 2 * e + 1);
  for (const auto& [name, part] : by_name_) {
    BudgetShare share{name,
                      c > 0 ? part.variance(2 * e) / c : 0.0,
                      r > 0 ? part.variance(2 * e + 1) / r : 0.0,
                      part.kind,
                      part.channel,
                      part.device,
                      part.mass};
    if (share.stiffness_share > 0 || share.damping_share > 0) out.push_back(std::move(share));
  }
  std::stable_sort(out.begin(), out.end(), [](const BudgetShare& a, const BudgetShare& b) {
    return a.stiffness_share + a.damping_share > b.stiffness_share + b.damping_share;
  });
  return out;
}

Propagation::Contribution& Propagation::add_effect(const std::string& name, double dof, SourceEffect effect) {
  const VectorXd& v = effect.on_coefficients;
  const Index count = v.size();
  covariance_ += v * v.transpose();
  Contribution& of_name =
      by_name_.try_emplace(name, Contribution{VectorXd::Zero(count), VectorXd::Constant(count, dof)}).first->second;
  of_name.variance += v.cwiseAbs2();
  effects_.push_back(std::move(effect));
  return of_name;
}

}  // namespace dwell
