#include "core/chain/estimate.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>
#include <tuple>

#include "core/base/angle.hpp"
#include "core/base/student.hpp"
#include "core/chain/chain_state.hpp"
#include "core/chain/identify.hpp"
#include "core/chain/linearity.hpp"
#include "core/chain/passivity.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::MatrixXcd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using Index = Eigen::Index;

double device_delay(const Rig& rig, const Channel& channel) {
  return channel.device >= 0 ? rig.devices[static_cast<std::size_t>(channel.device)].delay_s : 0.0;
}

// reading X = T · (displacement or force on the ground)
Complex transfer(const Rig& rig, const Channel& channel, Complex s) {
  return std::pow(s, derivative_order(channel.measures)) * response(channel, device_delay(rig, channel), s) *
         (channel.force_on_mass ? -1.0 : 1.0);
}
Complex transfer(const Rig& rig, const Channel& channel, double omega) {
  return transfer(rig, channel, Complex{0.0, omega});
}

// One source of error and what one standard deviation of it does.
struct Source {
  std::string name;
  double dof;             // infinity: type B
  VectorXcd on_x;         // to x
  VectorXcd on_Z;         // to Z directly, beside what it does through x
  double on_omega;        // to ω, rad/s
  bool residual = false;  // of residuals: where these are not white it is widened, element by element
  int mass = 0;           // as SourceEffect
  double clock_u = 0.0;
  std::vector<ReadingError> readings = {};
  VectorXcd bends_x = {};  // to x to second order, where an error turns phasors: -φ²/2 of them; empty: nothing
};

// What errors t_i ~ N(0, 1) do to Z = f/d of one element to second order (JCGM 100, 5.1.2, note): with A_i = ∂Z/∂t_i
// and B_i = ∂d/∂t_i / d it is Σ_ij q_ij t_i t_j, where q_ij = -(A_i B_j + A_j B_i)/2, and D_i beside it in q_ii where
// the error turns phasors. Of its components p, q (real, imaginary) the mean product is 2 Σ_ij q_ij,p q_ij,q + Σ_i
// q_ii,p Σ_i q_ii,q. With v = (Re A, Im A, Re B, Im B) and M = Σ_i v_i v_i' the sums are traces: q_ij,p = v_i' K_p v_j.
class SecondOrder {
 public:
  void add(Complex A, Complex B, Complex D) {
    const Eigen::Vector4d v{A.real(), A.imag(), B.real(), B.imag()};
    M_ += v * v.transpose();
    if (D == 0.0) return;
    const Complex own = -A * B, bent = own + D;
    const Eigen::Vector2d before{own.real(), own.imag()}, after{bent.real(), bent.imag()};
    beside_ += after * after.transpose() - before * before.transpose();
    mean_ += after - before;
  }
  // Mean products of (Re, Im) of what Z is off by.
  [[nodiscard]] Eigen::Matrix2d mean_product() const {
    Eigen::Matrix4d K[2] = {Eigen::Matrix4d::Zero(), Eigen::Matrix4d::Zero()};
    K[0](0, 2) = K[0](2, 0) = K[1](0, 3) = K[1](3, 0) = K[1](1, 2) = K[1](2, 1) = -0.5;
    K[0](1, 3) = K[0](3, 1) = 0.5;
    Eigen::Matrix2d product = 2 * beside_;
    const Eigen::Vector2d mean = mean_ + Eigen::Vector2d{(K[0] * M_).trace(), (K[1] * M_).trace()};
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q) product(p, q) += 2 * (K[p] * M_ * K[q] * M_).trace() + mean(p) * mean(q);
    return product;
  }

 private:
  Eigen::Matrix4d M_ = Eigen::Matrix4d::Zero();
  Eigen::Matrix2d beside_ = Eigen::Matrix2d::Zero();  // by D, of the sum of products
  Eigen::Vector2d mean_ = Eigen::Vector2d::Zero();    // by D
};

class Propagation {
 public:
  Propagation(const ChainState& chain, const MatrixXcd& force_rows, const MatrixXcd& deformation_rows,
              const VectorXcd& Z, const VectorXcd& d)
      : chain_(chain), Z_(Z), elements_(Z.size()) {
    through_x_.resize(elements_, chain.n + 2);
    for (Index e = 0; e < elements_; ++e)
      through_x_.row(e) = (force_rows.row(e) - Z(e) * deformation_rows.row(e)) / d(e);
    covariance_ = Eigen::MatrixXd::Zero(2 * elements_, 2 * elements_);
    deformation_rows_ = deformation_rows;
    deformation_variance_ = VectorXd::Zero(elements_);
    scatter_.resize(static_cast<std::size_t>(elements_));
    second_.resize(static_cast<std::size_t>(elements_));
    for (Index e = 0; e < elements_; ++e) deformation_rows_.row(e) /= d(e);
    d_ = d;
  }

  // What the elements' own stiffness scatters from stretch to stretch: before any source is added. per_reading: x by a
  // reading's phasor, (n + 2) × channels.
  void heed_scatter(const MatrixXcd& per_reading, const std::vector<Evidence>& evidence) {
    std::vector<std::vector<PhasorStretch>> stretches;
    for (const Evidence& seen : evidence) stretches.push_back(seen.stretches);
    for (Index e = 0; e < elements_; ++e)
      scatter_[static_cast<std::size_t>(e)] = scatter_of_sum((through_x_.row(e) * per_reading).transpose(), stretches);
  }

  void add(const Source& source) {
    const double omega = chain_.omega;
    VectorXd v(2 * elements_);
    for (Index e = 0; e < elements_; ++e) {
      const double widens = source.residual ? scatter_[static_cast<std::size_t>(e)].widens() : 1.0;
      const Complex dZ = through_x_.row(e).transpose().cwiseProduct(source.on_x).sum() + source.on_Z(e);
      v(2 * e) = dZ.real();
      v(2 * e + 1) = dZ.imag() / omega - damping(Z_(e), omega) * source.on_omega / omega;
      v.segment<2>(2 * e) *= std::sqrt(widens);
      // per component, which is what |d| against its noise is about
      const Complex relative = deformation_rows_.row(e).transpose().cwiseProduct(source.on_x).sum();
      deformation_variance_(e) += 0.5 * widens * std::norm(relative * d_(e));
      const Complex bent =
          source.bends_x.size() > 0 ? through_x_.row(e).transpose().cwiseProduct(source.bends_x).sum() : 0.0;
      second_[static_cast<std::size_t>(e)].add(std::sqrt(widens) * dZ, std::sqrt(widens) * relative, bent);
    }
    v = v.unaryExpr([](double a) { return std::isfinite(a) ? a : 0.0; });  // elements not determined are left out later
    const double mass_u = source.mass > 0 ? chain_.rig.mass_u[static_cast<std::size_t>(source.mass - 1)] : 0.0;
    Contribution& of_name =
        add_effect(source.name, source.dof, {v, source.mass, mass_u, source.clock_u, source.readings});
    for (Index e = 0; e < elements_; ++e)
      if (const Scatter& scatter = scatter_[static_cast<std::size_t>(e)]; source.residual && scatter.shows())
        of_name.dof.segment<2>(2 * e).setConstant(scatter.dof);
  }

  // What all sources together do to second order, once all are added.
  void add_second_order() {
    for (Index e = 0; e < elements_; ++e) {
      const Eigen::Matrix2d product = second_[static_cast<std::size_t>(e)].mean_product();
      if (!product.allFinite()) continue;  // of an element that is not determined
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(product);
      for (Index axis = 0; axis < 2; ++axis) {
        VectorXd v = VectorXd::Zero(2 * elements_);
        v.segment<2>(2 * e) = axes.eigenvectors().col(axis) * std::sqrt(std::max(0.0, axes.eigenvalues()(axis)));
        v(2 * e + 1) /= chain_.omega;
        add_effect("all to second order", std::numeric_limits<double>::infinity(), {v, 0, 0.0, 0.0, {}});
      }
    }
  }

  [[nodiscard]] double deformation_u(Index e) const { return std::sqrt(deformation_variance_(e)); }
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }
  [[nodiscard]] std::vector<SourceEffect>& effects() { return effects_; }
  // δZ of all elements by a change of x.
  [[nodiscard]] VectorXcd on_Z(const VectorXcd& change) const { return through_x_ * change; }

  [[nodiscard]] Coefficient coefficient(Index i, double value) const {
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

  [[nodiscard]] std::vector<BudgetShare> budget(Index e) const {
    std::vector<BudgetShare> out;
    const double c = covariance_(2 * e, 2 * e), r = covariance_(2 * e + 1, 2 * e + 1);
    for (const auto& [name, part] : by_name_) {
      BudgetShare share{name, c > 0 ? part.variance(2 * e) / c : 0.0, r > 0 ? part.variance(2 * e + 1) / r : 0.0};
      if (share.stiffness_share > 0 || share.damping_share > 0) out.push_back(std::move(share));
    }
    std::stable_sort(out.begin(), out.end(), [](const BudgetShare& a, const BudgetShare& b) {
      return a.stiffness_share + a.damping_share > b.stiffness_share + b.damping_share;
    });
    return out;
  }

 private:
  struct Contribution {
    VectorXd variance, dof;  // per coefficient
  };
  Contribution& add_effect(const std::string& name, double dof, SourceEffect effect) {
    const VectorXd& v = effect.on_coefficients;
    covariance_ += v * v.transpose();
    Contribution& of_name =
        by_name_.try_emplace(name, Contribution{VectorXd::Zero(2 * elements_), VectorXd::Constant(2 * elements_, dof)})
            .first->second;
    of_name.variance += v.cwiseAbs2();
    effects_.push_back(std::move(effect));
    return of_name;
  }

  const ChainState& chain_;
  const VectorXcd& Z_;
  Index elements_;
  MatrixXcd through_x_, deformation_rows_;  // of Z; of d, relative to d
  VectorXcd d_;
  Eigen::MatrixXd covariance_;
  VectorXd deformation_variance_;
  std::vector<Scatter> scatter_;     // per element
  std::vector<SecondOrder> second_;  // likewise
  std::vector<SourceEffect> effects_;
  std::map<std::string, Contribution> by_name_;
};

// The device, and which of its channels where it has several transactions: "line (y0, y1, y2 …)".
std::string name_of_transaction(const Rig& rig, const std::vector<Evidence>& evidence, int transaction) {
  constexpr int kNamed = 3;
  const int device = rig.channels[static_cast<std::size_t>(transaction)].device;
  std::string members;
  int count = 0;
  bool others = false;
  for (std::size_t c = 0; c < evidence.size(); ++c) {
    if (rig.channels[c].device != device) continue;
    if (evidence[c].transaction != transaction && static_cast<int>(c) != transaction) {
      others = others || evidence[c].turnaround_u_s > 0;
    } else if (++count <= kNamed) {
      members += (members.empty() ? "" : ", ") + rig.channels[c].name;
    }
  }
  if (count > kNamed) members += " …";
  if (device < 0) return members;
  return rig.devices[static_cast<std::size_t>(device)].name + (others ? " (" + members + ")" : "");
}

// The motion is no steady harmonic where its phasors have a slope: with y = Im(Y(t) exp(jωt)) the equations hold at any
// instant, and to first order in Ẏ the inertia has -2jω Σ m_i Ẏ_i beside ω² Σ m_i Y_i, the damper r_k ḋ_k. So what is
// taken for Z_k is too large by
//
//   (2jω Σ_{i>=k} m_i Ẏ_i + r_k ḋ_k) / d_k ,   element n+1: r_{n+1} Ẏ_n / Y_n
//
// whatever changes the phasors: a transient, a drive that hunts, a knock. None where no channel has a slope that shows.
std::optional<Source> change_within(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence,
                                    const ChainState& chain, const VectorXcd& Z, const VectorXcd& d) {
  bool shows = false;
  VectorXcd slopes = VectorXcd::Zero(gain.gain.cols()), read_off = slopes;
  for (Index c = 0; c < slopes.size(); ++c) {
    const Evidence& seen = evidence[static_cast<std::size_t>(c)];
    const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
    if (!seen.usable || gain.gain.col(c).isZero(0)) continue;
    shows = shows || seen.slope.shows();
    slopes(c) = as_observed(rig, static_cast<int>(c), seen.slope.value, chain.omega, 1);
    // A transducer of velocity reads jωY + Ẏ.
    read_off(c) = slopes(c) * static_cast<double>(derivative_order(channel.measures)) / Complex{0.0, chain.omega};
  }
  if (!shows) return {};
  const VectorXcd x_dot = gain.gain * slopes;
  VectorXcd on_Z(Z.size());
  Complex inertia = 0.0;
  if (Z.size() > chain.n) on_Z(chain.n) = damping(Z(chain.n), chain.omega) * x_dot.head(chain.n + 1).sum() / d(chain.n);
  for (int k = chain.n; k >= 1; --k) {
    inertia += rig.masses[static_cast<std::size_t>(k - 1)] * x_dot.head(k + 1).sum();
    on_Z(k - 1) = (Complex{0.0, 2 * chain.omega} * inertia + damping(Z(k - 1), chain.omega) * x_dot(k)) / d(k - 1);
  }
  return Source{"change within the dwell", std::numeric_limits<double>::infinity(), gain.gain * read_off, on_Z, 0.0};
}

// All sources that the rig file and the data name.
std::vector<Source> sources_of(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence,
                               const VectorXcd& o, const ChainState& chain, const VectorXcd& Z, const VectorXcd& d,
                               const Frequency& frequency) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double omega = frequency.omega;
  const Index elements = Z.size();
  std::vector<Source> out;
  const VectorXcd nothing = VectorXcd::Zero(elements);
  const auto through_channel = [&](Index c, Complex change) -> VectorXcd { return gain.gain.col(c) * change; };

  VectorXcd relative_omega = VectorXcd::Zero(chain.n + 2);  // ∂x/∂ω through the transducers
  // An error of instants that several channels share.
  struct Shared {
    VectorXcd on_x, bends_x;
    std::vector<ReadingError> readings;
  };
  std::map<int, Shared> by_device, by_transaction;
  // ∂²o/∂τ² u²/2
  const auto bent = [&](Complex delayed, double u_s) { return 0.5 * Complex{0.0, omega} * delayed * u_s * u_s; };
  const auto share = [&](std::map<int, Shared>& of, int key, Index c, Complex delayed, double u_s) {
    const VectorXcd none = VectorXcd::Zero(chain.n + 2);
    Shared& shared = of.try_emplace(key, Shared{none, none, {}}).first->second;
    shared.on_x += through_channel(c, delayed * u_s);
    shared.bends_x += through_channel(c, bent(delayed, u_s));
    shared.readings.push_back({.channel = c, .late_s = u_s});
  };
  const auto add_of_reading = [&](std::string name, VectorXcd on_x, std::vector<ReadingError> readings,
                                  VectorXcd bends_x = {}) {
    out.push_back({std::move(name), kInfinity, std::move(on_x), nothing, 0.0, false, 0, 0.0, std::move(readings),
                   std::move(bends_x)});
  };
  for (Index c = 0; c < o.size(); ++c) {
    const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
    const Evidence& seen = evidence[static_cast<std::size_t>(c)];
    if (!seen.usable || gain.gain.col(c).isZero(0)) continue;
    const Complex per_reading = 1.0 / transfer(rig, channel, omega);
    Eigen::Matrix2d turn;
    turn << per_reading.real(), -per_reading.imag(), per_reading.imag(), per_reading.real();
    // Two independent errors with each covariance: along the principal axes.
    const double rounding = std::norm(per_reading) * seen.quantization_u * seen.quantization_u;
    for (const auto& [name, covariance, dof] :
         {std::tuple<const char*, Eigen::Matrix2d, double>{"noise of ", turn * seen.covariance * turn.transpose(),
                                                           seen.dof},
          {"transient left in ", turn * seen.transient * turn.transpose(), kInfinity},
          {"quantization of ", rounding * Eigen::Matrix2d::Identity(), kInfinity},
          {"folded harmonics of ", std::norm(per_reading) * seen.folded_u * seen.folded_u * Eigen::Matrix2d::Identity(),
           kInfinity}}) {
      if (covariance.isZero(0)) continue;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
      for (Index axis = 0; axis < 2; ++axis) {
        const Eigen::Vector2d step = axes.eigenvectors().col(axis) * std::sqrt(std::max(0.0, axes.eigenvalues()(axis)));
        out.push_back(
            {name + channel.name, dof, through_channel(c, {step(0), step(1)}), nothing, 0.0, std::isfinite(dof)});
      }
    }
    const Complex delayed = Complex{0.0, omega} * o(c);  // ∂o/∂τ
    const LogSlopes slopes = response_slopes(channel, device_delay(rig, channel), omega / (kTwoPi));
    if (channel.scale_u > 0)
      add_of_reading("scale of " + channel.name, through_channel(c, o(c) * channel.scale_u),
                     {{.channel = c, .relative = channel.scale_u}});
    const auto add_late = [&](const std::string& name, double u_s) {
      if (u_s > 0)
        add_of_reading(name + channel.name, through_channel(c, delayed * u_s), {{.channel = c, .late_s = u_s}},
                       through_channel(c, bent(delayed, u_s)));
    };
    add_late("refresh of ", seen.refresh_u_s);
    add_late("delay of ", channel.delay_u_s);
    if (channel.lowpass.hz_u > 0)
      add_of_reading("low-pass of " + channel.name,
                     through_channel(c, -o(c) * slopes.lowpass_corner * channel.lowpass.hz_u),
                     {{.channel = c, .lowpass_hz = channel.lowpass.hz_u}});
    if (channel.highpass.hz_u > 0)
      add_of_reading("high-pass of " + channel.name,
                     through_channel(c, -o(c) * slopes.highpass_corner * channel.highpass.hz_u),
                     {{.channel = c, .highpass_hz = channel.highpass.hz_u}});
    if (channel.device >= 0)
      if (const double u = rig.devices[static_cast<std::size_t>(channel.device)].delay_u_s; u > 0)
        share(by_device, channel.device, c, delayed, u);
    if (seen.turnaround_u_s > 0)
      share(by_transaction, seen.transaction >= 0 ? seen.transaction : static_cast<int>(c), c, delayed,
            seen.turnaround_u_s);
    relative_omega += through_channel(
        c, -o(c) * (static_cast<double>(derivative_order(channel.measures)) / omega + slopes.frequency / (kTwoPi)));
  }
  for (auto& [device, shared] : by_device)
    add_of_reading("delay of " + rig.devices[static_cast<std::size_t>(device)].name, shared.on_x, shared.readings,
                   shared.bends_x);
  for (auto& [transaction, shared] : by_transaction)
    add_of_reading("turnaround of " + name_of_transaction(rig, evidence, transaction), shared.on_x, shared.readings,
                   shared.bends_x);

  for (std::size_t i = 0; i < rig.mass_u.size(); ++i) {
    if (!(rig.mass_u[i] > 0)) continue;
    VectorXcd on_Z = nothing;
    for (Index e = 0; e <= static_cast<Index>(i) && e < chain.n; ++e)
      on_Z(e) = omega * omega * chain.Y(static_cast<int>(i) + 1) * rig.mass_u[i] / d(e);
    out.push_back({"mass " + std::to_string(i + 1), kInfinity, VectorXcd::Zero(chain.n + 2), on_Z, 0.0, false,
                   static_cast<int>(i) + 1});
  }

  VectorXcd by_omega = nothing;  // 2ω Σ_{i>=k} m_i Y_i / d_k
  Complex inertia = 0.0;
  for (int k = chain.n; k >= 1; --k) {
    inertia += rig.masses[static_cast<std::size_t>(k - 1)] * chain.Y(k);
    by_omega(k - 1) = 2 * omega * inertia / d(k - 1);
  }
  VectorXcd absorbed = VectorXcd::Zero(chain.n + 2);
  for (Index c = 0; c < o.size(); ++c)
    if (const Evidence& seen = evidence[static_cast<std::size_t>(c)]; seen.usable)
      absorbed += through_channel(c, as_observed(rig, static_cast<int>(c), seen.absorbed, omega, 1));
  if (!absorbed.isZero(0)) out.push_back({"drive's change while settling", kInfinity, absorbed, nothing, 0.0});
  if (const auto change = change_within(rig, gain, evidence, chain, Z, d)) out.push_back(*change);
  for (const auto& [name, u] : {std::pair<const char*, double>{"frequency", frequency.u},
                                std::pair<const char*, double>{"clock rate", frequency.clock_u * omega}})
    if (u > 0)
      out.push_back({name, kInfinity, relative_omega * u, by_omega * u, u, false, 0,
                     std::string_view(name) == "clock rate" ? frequency.clock_u : 0.0});
  return out;
}

// Per element: whether each channel has a part in its force or deformation.
std::vector<std::vector<bool>> channels_used(const Gain& gain, const MatrixXcd& force_rows,
                                             const MatrixXcd& deformation_rows) {
  std::vector<std::vector<bool>> used(static_cast<std::size_t>(force_rows.rows()));
  for (Index e = 0; e < force_rows.rows(); ++e)
    for (Index c = 0; c < gain.gain.cols(); ++c)
      used[static_cast<std::size_t>(e)].push_back(gain.uses(force_rows.row(e).transpose(), c) ||
                                                  gain.uses(deformation_rows.row(e).transpose(), c));
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

Complex as_observed(const Rig& rig, int channel, Complex X, double omega, int h) {
  return X / transfer(rig, rig.channels[static_cast<std::size_t>(channel)], h * omega);
}

VectorXd observation_weights(const Rig& rig, const std::vector<Evidence>& evidence, double omega) {
  VectorXd weights = VectorXd::Zero(static_cast<Index>(rig.channels.size()));
  // Displacement and force are weighed each among their own; a common factor for either changes nothing.
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    if (!evidence[c].usable || rig.channels[c].measures == Quantity::auxiliary) continue;
    const Complex T = transfer(rig, rig.channels[c], omega);
    const double noise = std::sqrt(0.5 * evidence[c].widened * evidence[c].covariance.trace());
    const double size = std::abs(evidence[c].X[0]);
    // 1e-12: a reading without noise must not outweigh the others without bound.
    weights(static_cast<Index>(c)) =
        std::abs(T) / std::hypot(noise, rig.channels[c].scale_u * size, 1e-12 * size + 1e-300);
  }
  const double largest = weights.maxCoeff();
  for (const bool force : {false, true}) {
    double scale = 0.0;
    for (std::size_t c = 0; c < rig.channels.size(); ++c)
      if ((rig.channels[c].measures == Quantity::force) == force)
        scale = std::max(scale, weights(static_cast<Index>(c)));
    for (std::size_t c = 0; c < rig.channels.size(); ++c)
      if ((rig.channels[c].measures == Quantity::force) == force && scale > 0) weights(static_cast<Index>(c)) /= scale;
  }
  return largest > 0 ? weights : VectorXd::Zero(weights.size());
}

Complex as_observed(const Rig& rig, int channel, Complex a, Complex s) {
  return a / transfer(rig, rig.channels[static_cast<std::size_t>(channel)], s);
}

Complex observed_too_small(const Rig& rig, const ReadingError& error, Complex s) {
  constexpr double kStep = 1e-4;  // relative, of a corner
  const Channel& channel = rig.channels[static_cast<std::size_t>(error.channel)];
  const auto by_corner = [&](Filter filter, bool high, double change_hz) {
    if (change_hz == 0) return Complex{};
    const double hz = filter.hz;
    filter.hz = hz * (1 + kStep);
    const Complex above = filter_response(filter, high, s);
    filter.hz = hz * (1 - kStep);
    return std::log(above / filter_response(filter, high, s)) / (2 * kStep * hz) * change_hz;
  };
  return error.relative + s * error.late_s - by_corner(channel.lowpass, false, error.lowpass_hz) -
         by_corner(channel.highpass, true, error.highpass_hz);
}

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
  MatrixXcd force_rows(elements, n + 2), deformation_rows(elements, n + 2);
  VectorXcd Z(elements), d(elements), f(elements);
  std::vector<bool> determined(static_cast<std::size_t>(elements));
  for (Index e = 0; e < elements; ++e) {
    const int k = static_cast<int>(e) + 1;
    force_rows.row(e) = chain.force_row(k).transpose();
    deformation_rows.row(e) = chain.deformation_row(k).transpose();
    determined[static_cast<std::size_t>(e)] =
        gain.determines(force_rows.row(e).transpose()) && gain.determines(deformation_rows.row(e).transpose());
    f(e) = force_rows.row(e).transpose().cwiseProduct(chain.x).sum();
    d(e) = deformation_rows.row(e).transpose().cwiseProduct(chain.x).sum();
    Z(e) = f(e) / d(e);
  }

  Propagation propagation(chain, force_rows, deformation_rows, Z, d);
  MatrixXcd x_per_reading = gain.gain.cast<Complex>();
  for (Index c = 0; c < channels; ++c)
    x_per_reading.col(c) *= as_observed(rig, static_cast<int>(c), 1.0, frequency.omega, 1);
  propagation.heed_scatter(x_per_reading, evidence);
  for (const Source& source : sources_of(rig, gain, evidence, o, chain, Z, d, frequency)) propagation.add(source);
  propagation.add_second_order();

  ElementsResult result;
  const std::string missing = missing_channels(rig, evidence);
  for (Index e = 0; e < elements; ++e) {
    ElementEstimate element;
    element.k = static_cast<int>(e) + 1;
    const bool known = determined[static_cast<std::size_t>(e)];
    if (!known) {
      element.reason = missing.empty() ? "the channels present do not determine it" : missing;
      Z(e) = Complex{kNaN, kNaN};
    } else {
      element.deformation = {std::abs(d(e)), propagation.deformation_u(e)};
      const Coefficient c = propagation.coefficient(2 * e, stiffness(Z(e)));
      const Coefficient r = propagation.coefficient(2 * e + 1, damping(Z(e), frequency.omega));
      const double u_Z = std::hypot(c.u, frequency.omega * r.u);
      if (!(element.deformation.value > 3 * element.deformation.u)) {
        element.reason = "it barely deforms: |d| is not above 3 u(d)";
      } else if (!(u_Z < std::abs(Z(e)) / 3)) {
        element.reason = "its force is not resolved: u(Z) is not below |Z|/3";
        if (const std::vector<BudgetShare> budget = propagation.budget(e); !budget.empty())
          element.reason += ", most of it by " + budget.front().source;
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
    result.elements.push_back(std::move(element));
  }
  result.Z.assign(Z.data(), Z.data() + Z.size());
  refuse_negative(rig, channels_used(gain, force_rows, deformation_rows), result.elements, result.doubts);
  result.warnings = judge_linearity(rig, gain, evidence, frequency, result.elements);
  std::vector<Index> rows;
  for (Index e = 0; e < elements; ++e)
    if (result.elements[static_cast<std::size_t>(e)].identifiable) rows.insert(rows.end(), {2 * e, 2 * e + 1});
  result.effects = std::move(propagation.effects());
  result.by_channel.resize(elements, channels);
  for (Index c = 0; c < channels; ++c) result.by_channel.col(c) = propagation.on_Z(gain.gain.col(c) * o(c));
  result.gain = gain.gain;
  result.Y.resize(n + 1);
  for (int k = 0; k <= n; ++k) result.Y(k) = chain.Y(k);
  result.d = d;
  for (const Index i : rows)
    for (const Index j : rows) result.covariance.push_back(propagation.covariance()(i, j));
  return result;
}

}  // namespace dwell
