#include "core/transient/seen_modes.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/chance.hpp"
#include "core/base/complex.hpp"

namespace dwell {
namespace {

using Eigen::Index;

// Largest standard deviation of a pole, relative to the larger of 1/T and its decay rate. Above it the error is no
// longer normal. Doubled, poles of weak modes take part whose errors exceed their uncertainty; halved, faults go unseen
// that the data do resolve.
constexpr double kResolvedPole = 0.2;
// Where the last step moved a pole by less than kSettledPole standard deviations, its variance grows by the square of
// the step. Otherwise the fit is not at its optimum: the variance grows by the square of kUnsettled steps.
constexpr double kSettledPole = 1.0, kUnsettled = 10.0;
// Probability that the channels disagree as much by chance. Below it the pole is not that of a mode of the whole rig
// alone. At a tenth of this, brackets that ring beside a mode are taken for the chain. At ten times as much a sound
// mode goes unused now and then, which the next fit mends.
constexpr double kOneChannel = 1e-3;
constexpr int kMostChanges = 2 * ModalMotion::kMaxModes + 1;  // of the poles and of ω

}  // namespace

SeenModes::SeenModes(int channels) {
  const auto prepare = [&](SeenMode& mode) {
    mode.amplitude.setZero(channels);
    mode.covariance.setZero(2 * channels + 2, 2 * channels + 2);
    mode.fitted.resize(static_cast<std::size_t>(channels));
  };
  for (SeenMode& mode : modes_) prepare(mode);
  prepare(now_);
}

double SeenModes::widened(const ModalFit& fit, const HoldNow& now, const SharedInstants& instants) noexcept {
  const auto takes_part = [&](std::size_t c) { return fit.usable(static_cast<int>(c)) && !now.channels[c].imposed; };
  double most = 1.0;
  for (std::size_t c = 0; c < now.channels.size(); ++c) {
    const auto i = static_cast<int>(c);
    const int transaction = now.channels[c].transaction;
    const double u_s = instants.u_s(transaction);
    if (!takes_part(c) || !(u_s > 0) || !(fit.variance(i) > 0)) continue;
    double speed2 = 0.5 * std::norm(now.omega * fit.phasor(i, 1));  // mean square at the fit's begin
    for (std::size_t m = 0; m < fit.poles().size(); ++m)
      speed2 += 0.5 * std::norm(fit.poles()[m] * fit.amplitude(i, m));
    const double part = std::min(1.0, speed2 * u_s * u_s / fit.variance(i));
    double others = 0.0;
    for (std::size_t o = 0; o < now.channels.size(); ++o)
      if (o != c && takes_part(o) && now.channels[o].transaction == transaction) others += 1.0;
    most = std::max(most, 1 + others * part);
  }
  return most;
}

void SeenModes::describe(const ModalFit& fit, std::size_t m, const HoldNow& now, std::span<const double> left_over,
                         double widened, double extra, SeenMode& mode) noexcept {
  const auto channels = mode.amplitude.size(), pole = 2 * channels;
  const double size = std::abs(fit.poles()[m]);
  using OfPoles = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostChanges, kMostChanges>;
  using Rows = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMostChanges>;
  const OfPoles of_poles = widened * fit.propagated();
  const ModalFit::Change change = fit.last_change();
  const auto at_pole = 2 * static_cast<Index>(m);
  mode.pole = fit.moved_poles()[m];
  mode.seen_s = to_s(now.now_ns - fit.t0_ns());
  mode.covariance.setZero();
  mode.covariance.block<2, 2>(pole, pole) =
      size * size * of_poles.block<2, 2>(at_pole, at_pole) + extra * Eigen::Matrix2d::Identity();
  for (Index c = 0; c < channels; ++c) {
    const int channel = static_cast<int>(c);
    const bool fitted = fit.has_propagated(channel);
    mode.fitted[static_cast<std::size_t>(c)] = fitted;
    mode.amplitude(c) = 0.0;
    if (!fitted) continue;
    const Rows by = fit.amplitude_by_poles(channel, m);
    const Rows onto = by.lazyProduct(of_poles);
    const Eigen::Vector2d step = by.lazyProduct(change);
    mode.amplitude(c) = fit.amplitude(channel, m) + Complex{step(0), step(1)};
    const Eigen::Matrix2d to_pole = size * onto.middleCols<2>(at_pole);
    mode.covariance.block<2, 2>(2 * c, pole) = to_pole;
    mode.covariance.block<2, 2>(pole, 2 * c) = to_pole.transpose();
    for (Index other = 0; other <= c; ++other) {
      if (!mode.fitted[static_cast<std::size_t>(other)]) continue;
      const Eigen::Matrix2d both = onto.lazyProduct(fit.amplitude_by_poles(static_cast<int>(other), m).transpose());
      mode.covariance.block<2, 2>(2 * c, 2 * other) = both;
      mode.covariance.block<2, 2>(2 * other, 2 * c) = both.transpose();
    }
    mode.covariance.block<2, 2>(2 * c, 2 * c) +=
        widened * fit.amplitude_covariance(channel, m) +
        beyond_noise(fit, m, static_cast<std::size_t>(c), now, left_over) * Eigen::Matrix2d::Identity();
  }
}

double SeenModes::beyond_noise(const ModalFit& fit, std::size_t m, std::size_t channel, const HoldNow& now,
                               std::span<const double> left_over) noexcept {
  const auto c = static_cast<int>(channel);
  const double speed2 = std::norm(fit.poles()[m] * fit.amplitude(c, m)) + std::norm(now.omega * fit.phasor(c, 1));
  return std::max(0.0, left_over[channel]) + speed2 * std::pow(now.channels[channel].widest_refresh_half_s, 2) / 3;
}

// Variance to add to either component of the pole of mode m, beyond what the fit says.
double SeenModes::extra_pole_variance(const ModalFit& fit, std::size_t m, double scale, const HoldNow& now,
                                      std::span<const double> left_over) noexcept {
  double moved = 0.0;  // relative error of the pole that the residuals allow, at most; squared
  for (std::size_t c = 0; c < left_over.size(); ++c) {
    const int channel = static_cast<int>(c);
    if (!fit.usable(channel)) continue;
    const double a = std::abs(fit.amplitude(channel, m));
    // A channel that hardly shows this mode tells of others.
    if (a > sigmas::kNoise * fit.u_amplitude(channel, m))
      moved = std::max(moved, 2 * beyond_noise(fit, m, c, now, left_over) / (a * a));
  }
  // A pole that still moves is known less well than the data would allow.
  const Complex step = fit.moved_poles()[m] - fit.poles()[m];
  const Eigen::Vector2d moves(step.real(), step.imag());
  const bool settled = moves.dot(fit.pole_covariance(m).inverse() * moves) < kSettledPole * kSettledPole;
  return moved * scale * scale + (settled ? 1.0 : kUnsettled * kUnsettled) * moves.squaredNorm();
}

void SeenModes::take(const ModalFit& fit, const HoldNow& now, const SharedInstants& instants,
                     std::span<const double> left_over) noexcept {
  const double seen_s = to_s(now.now_ns - fit.t0_ns());
  const auto refined = fit.moved_poles();
  const double by = widened(fit, now, instants);
  std::array<double, ModalMotion::kMaxModes> u{}, extra{};
  for (std::size_t m = 0; m < refined.size(); ++m) {
    const double decays = -refined[m].real(), scale = std::max(decays, 1 / std::max(1e-9, seen_s));
    extra[m] = extra_pole_variance(fit, m, scale, now, left_over);
    const auto at = 2 * static_cast<Index>(m);
    const double size = std::abs(fit.poles()[m]);
    u[m] = std::sqrt(by * size * size * fit.propagated().block<2, 2>(at, at).trace() + 2 * extra[m]);
    if (!(u[m] < kResolvedPole * scale)) u[m] = INFINITY;
  }
  for (std::size_t m = 0; m < refined.size(); ++m) {
    const Complex pole = refined[m];
    if (!(pole.real() < 0) || !(pole.imag() > 0) || !std::isfinite(u[m])) continue;
    if (!fit.certain(m)) continue;
    if (fit.disagreement(m) > -2 * std::log(kOneChannel / static_cast<double>(left_over.size()))) continue;
    // Two poles must surely differ. Nearer ones could as well be exchanged, and the fit is far from linear. A pole that
    // is not resolved is left out, and so are poles nearer to it than the sum of both decay rates: it disturbs them.
    bool alone = true;
    for (std::size_t other = 0; other < refined.size() && alone; ++other) {
      if (other == m || !(refined[other].real() < 0) || !fit.certain(other)) continue;
      const double apart = std::abs(refined[other] - pole);
      alone = apart > (std::isfinite(u[other]) ? sigmas::kSure * std::hypot(u[m], u[other])
                                               : -pole.real() - refined[other].real());
    }
    if (!alone) continue;
    describe(fit, m, now, left_over, by, extra[m], now_);
    const auto end = modes_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto before = std::find_if(modes_.begin(), end, [&](const SeenMode& other) {
      return std::norm(other.pole - pole) <
             sigmas::kSure * sigmas::kSure * (other.pole_covariance().trace() + now_.pole_covariance().trace());
    });
    if (before == modes_.end()) continue;
    if (before != end && before->pole_covariance().trace() < now_.pole_covariance().trace()) continue;
    if (before == end) ++count_;
    before->pole = now_.pole;
    before->seen_s = now_.seen_s;
    before->amplitude = now_.amplitude;
    before->covariance = now_.covariance;
    std::copy(now_.fitted.begin(), now_.fitted.end(), before->fitted.begin());
  }
}

}  // namespace dwell
