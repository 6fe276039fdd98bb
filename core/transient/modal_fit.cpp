#include "core/transient/modal_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

using Eigen::Index;

constexpr double kSecondPerNs = 1e-9;
constexpr double kStandsOut = 2.5;  // standard deviations of either component from which an amplitude is believed
// Probability that noise is fitted by such amplitudes at one given pole. Where the pole is chosen among some hundred
// lines and refined on them, at ten begins of a hold, that is once in 10⁶ holds. At 1e-6 one of 2000 healthy dwells of
// the study was doubted for a mode that was noise.
constexpr double kOfNoise = 1e-9;
constexpr double kNothingOpen = 1e-6, kSurely = 1e3;  // of the variance that the data leave; χ²

}  // namespace

ModalFit::ModalFit(int channels, int harmonics, int modes)
    : regressors_(harmonics, modes),
      moved_(regressors_.capacity()),
      u_poles_(regressors_.capacity()),
      disagreement_(regressors_.capacity()) {
  const Index steady = regressors_.steady(), most = 2 * static_cast<Index>(regressors_.capacity()),
              all = steady + 2 * most + 2;
  work_.resize(steady + most, steady + most);
  columns_.resize(steady + most, most + 2);
  slopes_.resize(most + 2, most + 2);
  hessian_.resize(most + 1, most + 1);
  products_.resize(2 * most + 2, most + 1);
  relative_covariance_.setZero(most + 1, most + 1);
  propagated_.resize(most + 1, most + 1);
  gradient_.resize(most + 1);
  product_.resize(steady + most);
  channels_.resize(static_cast<std::size_t>(channels));
  for (PerChannel& channel : channels_) {
    channel.normal.resize(all, all);
    channel.pending.resize(all, kTogether);
    channel.moments.resize(all);
    channel.theta.resize(steady + most);
    channel.covariance.resize(most, most);
    channel.by_poles.resize(2 * most, most + 1);
    channel.whole.resize(2 * most, 2 * most);
  }
}

void ModalFit::restart(double omega, double rate, std::int64_t t0_ns, std::span<const Complex> poles) noexcept {
  regressors_.restart(omega, rate, t0_ns, poles);
  newest_ns_ = t0_ns;
  for (PerChannel& channel : channels_) {
    channel.normal.setZero();
    channel.moments.setZero();
    channel.squares = channel.samples = 0.0;
    channel.pending_count = 0;
    channel.usable = channel.referenced = channel.propagated = false;
  }
}

void ModalFit::add(int channel, std::int64_t t_ns, double value) noexcept {
  const Eigen::VectorXd& x = regressors_.at(t_ns);
  newest_ns_ = std::max(newest_ns_, t_ns);
  PerChannel& to = channels_[static_cast<std::size_t>(channel)];
  if (!to.referenced) {
    to.reference = value;
    to.referenced = true;
  }
  const double s = value - to.reference;
  const Index all = linear() + slopes();
  to.moments.head(all) += s * x.head(all);
  to.squares += s * s;
  to.samples += 1.0;
  // The products of several samples at once: it is the going through the matrix that costs.
  to.pending.col(to.pending_count).head(all) = x.head(all);
  if (++to.pending_count == kTogether) add_pending(to);
}

void ModalFit::add_pending(PerChannel& to) noexcept {
  static_assert(kTogether == 4);
  const Index all = linear() + slopes();
  for (Index i = to.pending_count; i < kTogether; ++i) to.pending.col(i).setZero();
  const double *x0 = &to.pending(0, 0), *x1 = &to.pending(0, 1), *x2 = &to.pending(0, 2), *x3 = &to.pending(0, 3);
  for (Index j = 0; j < all; ++j) {
    double* column = &to.normal(0, j);
    const double a = x0[j], b = x1[j], c = x2[j], d = x3[j];
    for (Index i = j; i < all; ++i) column[i] += (a * x0[i] + b * x1[i]) + (c * x2[i] + d * x3[i]);
  }
  to.pending_count = 0;
}

bool ModalFit::solve(int channel, double range, double line_range) noexcept {
  PerChannel& of = channels_[static_cast<std::size_t>(channel)];
  const Index P = linear();
  of.usable = of.propagated = false;
  if (of.pending_count > 0) add_pending(of);
  if (!(of.samples > static_cast<double>(P + 4))) return false;
  const double width2 = std::max(line_range * line_range, 1e-300);
  const double tighter = width2 / std::max(range * range, 1e-300);  // of what decays
  double sigma2 = of.sigma2 > 0 ? std::min(of.sigma2, width2) : width2;
  // The weight of the prior against the data depends on the noise, and the noise on the fit: twice is enough.
  for (int pass = 0; pass < 2; ++pass) {
    auto factor = work_.topLeftCorner(P, P);
    factor = of.normal.topLeftCorner(P, P);
    of.line_prior = std::max(sigma2 / width2, 1e-12 * of.samples);
    of.prior = std::max(sigma2 / width2 * tighter, 1e-12 * of.samples);
    for (Index i = steady(); i < P; ++i)
      factor(i, i) += poles()[static_cast<std::size_t>((i - steady()) / 2)].real() < 0 ? of.prior : of.line_prior;
    for (Index i = 0; i < steady(); ++i) factor(i, i) *= 1 + 1e-13;
    Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(factor);
    if (llt.info() != Eigen::Success) return false;
    of.theta.head(P) = of.moments.head(P);
    llt.solveInPlace(of.theta.head(P));
    // Of the residuals, the prior left aside.
    product_.head(P).noalias() = of.normal.topLeftCorner(P, P).selfadjointView<Eigen::Lower>() * of.theta.head(P);
    const double squares = of.squares + of.theta.head(P).dot(product_.head(P) - 2 * of.moments.head(P));
    sigma2 = std::max(squares, 1e-15 * of.squares) / (of.samples - static_cast<double>(P));
    if (pass == 1) {
      auto columns = columns_.topLeftCorner(P, modal());
      columns.setZero();
      for (Index i = 0; i < modal(); ++i) columns(steady() + i, i) = 1.0;
      llt.solveInPlace(columns);
      of.covariance.topLeftCorner(modal(), modal()) = sigma2 * columns.bottomRows(modal());
    }
  }
  of.sigma2 = sigma2;
  of.usable = of.theta.head(P).allFinite() && std::isfinite(sigma2);
  return of.usable;
}

double ModalFit::misfit() const noexcept {
  const double off = omega() - stated_.omega;
  double sum = off * off * stated_.information();
  for (const PerChannel& channel : channels_)
    if (channel.usable) sum += channel.samples * std::log(std::max(channel.sigma2, 1e-300));
  return sum;
}

Complex ModalFit::phasor(int channel, int h) const noexcept {
  const PerChannel& of = at(channel);
  return {of.theta(h), of.theta(regressors_.harmonics() + h)};
}

Complex ModalFit::amplitude(int channel, std::size_t mode) const noexcept {
  const auto i = steady() + 2 * static_cast<Index>(mode);
  return {at(channel).theta(i), at(channel).theta(i + 1)};
}

double ModalFit::u_amplitude(int channel, std::size_t mode) const noexcept {
  const auto i = 2 * static_cast<Index>(mode);
  const Eigen::MatrixXd& covariance = at(channel).covariance;
  return std::sqrt(std::max(0.0, 0.5 * (covariance(i, i) + covariance(i + 1, i + 1))));
}

bool ModalFit::shows(std::size_t mode) const noexcept {
  const auto i = 2 * static_cast<Index>(mode);
  for (const PerChannel& of : channels_)
    if (of.usable && of.theta.segment<2>(steady() + i).squaredNorm() >
                         kStandsOut * kStandsOut * 0.5 * (of.covariance(i, i) + of.covariance(i + 1, i + 1)))
      return true;
  return false;
}

// χ² of the amplitudes, two degrees of freedom a channel, against exp(-x/2) Σ_{i<C} (x/2)^i / i!.
bool ModalFit::certain(std::size_t mode) const noexcept {
  const auto i = 2 * static_cast<Index>(mode);
  double half = 0.0;
  int shown = 0;
  for (const PerChannel& of : channels_) {
    if (!of.usable) continue;
    const Eigen::Vector2d a = of.theta.segment<2>(steady() + i);
    // What is imposed has no transient, by a prior that leaves nothing open.
    if (!(of.covariance(i, i) > kNothingOpen * of.sigma2 / of.samples)) continue;
    half += 0.5 * std::min(kSurely, a.dot(of.covariance.block<2, 2>(i, i).inverse() * a));
    ++shown;
  }
  double term = std::exp(-half), sum = 0.0;
  for (int k = 1; k <= shown; ++k) {
    sum += term;
    term *= half / k;
  }
  return shown > 0 && sum < kOfNoise;
}

ModalFit::Left ModalFit::left(int channel, std::int64_t t_ns) const noexcept {
  const PerChannel& of = at(channel);
  const double u = kSecondPerNs * static_cast<double>(t_ns - t0_ns());
  Left left{0.0, 0.0, 0.0};
  for (std::size_t m = 0; m < poles().size(); ++m) {
    const auto i = 2 * static_cast<Index>(m);
    if (!(poles()[m].real() < 0)) continue;
    const double decayed = std::exp(poles()[m].real() * u);
    const Eigen::Vector2d a = of.theta.segment<2>(steady() + i);
    const double own = std::sqrt(0.5 * std::max(0.0, of.covariance(i, i) + of.covariance(i + 1, i + 1)));
    if (a.norm() > kStandsOut * own) left.envelope += decayed * a.norm();
  }
  // The uncertainty at its largest over half a cycle of the drive.
  const Eigen::MatrixXd& covariance = of.propagated ? of.whole : of.covariance;
  const Index errors = of.propagated ? 2 * modal() : modal();
  for (int angle = 0; angle < 8; ++angle) {
    const double later = u + angle * std::numbers::pi / 8 / omega();
    std::array<double, 4 * kMaxModes> x;
    for (std::size_t m = 0; m < poles().size(); ++m) {
      const Complex e = poles()[m].real() < 0 ? std::exp(poles()[m] * later) : Complex{};
      const std::size_t i = 2 * m, slope = static_cast<std::size_t>(modal()) + i;
      x[i] = e.real();
      x[i + 1] = poles()[m].imag() > 0 ? -e.imag() : 0.0;
      x[slope] = regressors_.sizes()[m] * later * x[i];
      x[slope + 1] = regressors_.sizes()[m] * later * x[i + 1];
    }
    double swing = 0.0, variance = 0.0;
    for (Index j = 0; j < modal(); ++j) swing += of.theta(steady() + j) * x[static_cast<std::size_t>(j)];
    left.swing = std::max(left.swing, std::abs(swing));
    for (Index j = 0; j < errors; ++j) {
      double row = 0.5 * covariance(j, j) * x[static_cast<std::size_t>(j)];
      for (Index i = j + 1; i < errors; ++i) row += covariance(i, j) * x[static_cast<std::size_t>(i)];
      variance += 2 * row * x[static_cast<std::size_t>(j)];
    }
    left.u = std::max(left.u, variance);
  }
  left.u = std::sqrt(std::max(0.0, left.u));
  // Modes that the data can hardly tell apart may all be uncertain while their sum is not.
  Complex sum{};
  for (std::size_t m = 0; m < poles().size(); ++m)
    if (poles()[m].real() < 0)
      sum +=
          Complex{of.theta(steady() + 2 * static_cast<Index>(m)), of.theta(steady() + 2 * static_cast<Index>(m) + 1)} *
          std::exp(poles()[m] * u);
  if (std::abs(sum) > kStandsOut * left.u) left.envelope = std::max(left.envelope, std::abs(sum));
  return left;
}

double ModalFit::most(int channel, std::size_t m, std::int64_t t_ns) const noexcept {
  const PerChannel& of = at(channel);
  const auto i = 2 * static_cast<Index>(m);
  return std::exp(poles()[m].real() * kSecondPerNs * static_cast<double>(t_ns - t0_ns())) *
         (of.theta.segment<2>(steady() + i).norm() +
          3 * std::sqrt(std::max(0.0, 0.5 * (of.covariance(i, i) + of.covariance(i + 1, i + 1)))));
}

void ModalFit::overlap_at(std::int64_t t_ns, Eigen::Matrix<double, 2, Eigen::Dynamic>& B) noexcept {
  const Eigen::VectorXd& x = regressors_.at(t_ns);
  const double sine = x(1), cosine = x(regressors_.harmonics() + 1);
  for (Index i = 0; i < 2 * modal(); ++i) {
    B(0, i) += sine * x(steady() + i);
    B(1, i) += cosine * x(steady() + i);
  }
}

double ModalFit::residual(int channel, std::int64_t t_ns, double value) noexcept {
  const Eigen::VectorXd& x = regressors_.at(t_ns);
  const PerChannel& of = at(channel);
  return value - of.reference - of.theta.head(linear()).dot(x.head(linear()));
}

double ModalFit::disturbance(int channel, std::int64_t t_ns) noexcept {
  const Eigen::VectorXd& x = regressors_.at(t_ns);
  const PerChannel& of = at(channel);
  if (!of.usable) return 0.0;
  double sum = 0.0;
  for (std::size_t m = 0; m < poles().size(); ++m)
    for (const Index i : {steady() + 2 * static_cast<Index>(m), steady() + 2 * static_cast<Index>(m) + 1})
      sum += of.theta(i) * x(i);
  return sum;
}

Eigen::Matrix2d ModalFit::spread(int channel, const Eigen::Ref<const Eigen::MatrixXd>& B) const noexcept {
  const PerChannel& of = at(channel);
  if (!of.usable) return Eigen::Matrix2d::Zero();
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  const Eigen::MatrixXd& covariance = of.propagated ? of.whole : of.covariance;
  const Index errors = of.propagated ? 2 * modal() : modal();
  for (Index j = 0; j < errors; ++j)
    for (Index i = 0; i < errors; ++i)
      spread.noalias() += covariance(std::max(i, j), std::min(i, j)) * B.col(i).lazyProduct(B.col(j).transpose());
  return spread;
}

Eigen::Vector2d ModalFit::taken_out(int channel, const Eigen::Ref<const Eigen::MatrixXd>& B) const noexcept {
  const PerChannel& of = at(channel);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  if (!of.usable) return sum;
  for (Index i = 0; i < modal(); ++i) sum += B.col(i) * of.theta(steady() + i);
  return sum;
}

}  // namespace dwell
