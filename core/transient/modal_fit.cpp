#include "core/transient/modal_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

using Eigen::Index;

constexpr double kStandsOut = 2.5;  // an amplitude is believed from so many standard deviations of either component
// Probability that noise at one given pole gives such amplitudes. Where the pole is chosen among some hundred lines and
// refined on them, at ten begins of a hold, this is once in 10⁶ holds. At 1e-6 one of 2000 healthy dwells of the study
// was doubted for a mode that was noise.
constexpr double kOfNoise = 1e-9;
// kNothingOpen: below this part of σ²/N the prior fixes the amplitude. kSurely: a channel adds no more to χ².
constexpr double kNothingOpen = 1e-6, kSurely = 1e3;

}  // namespace

ModalFit::ModalFit(int channels, int harmonics, int modes)
    : regressors_(harmonics, modes),
      sums_(channels, ModalLayout{harmonics, static_cast<Index>(regressors_.motion().capacity())}.all()),
      linear_(harmonics, static_cast<Index>(regressors_.motion().capacity())),
      step_(static_cast<Index>(regressors_.motion().capacity())),
      errors_(static_cast<Index>(regressors_.motion().capacity())) {
  const auto most = static_cast<Index>(regressors_.motion().capacity());
  channels_.reserve(static_cast<std::size_t>(channels));
  for (int c = 0; c < channels; ++c) channels_.push_back({ModalSolution(harmonics, most), PoleErrors::Effect(most)});
}

void ModalFit::restart(double omega, double rate, std::int64_t t0_ns, std::span<const Complex> poles) noexcept {
  regressors_.restart(omega, rate, t0_ns, poles);
  newest_ns_ = t0_ns;
  sums_.clear();
  for (PerChannel& channel : channels_) channel.solution.usable = channel.errors.known = false;
}

double ModalFit::add(int channel, std::int64_t t_ns, double value) noexcept {
  newest_ns_ = std::max(newest_ns_, t_ns);
  const Eigen::VectorXd& x = regressors_.at(t_ns);
  return sums_.add(channel, regressors_.computed(), x, layout().all(), value);
}

bool ModalFit::solve(int channel, double range, double line_range) noexcept {
  PerChannel& of = at(channel);
  of.errors.known = false;
  sums_.complete(channel, layout().all());
  return linear_.solve(layout(), regressors_.motion(), sums_.of(channel), range, line_range, of.solution);
}

double ModalFit::misfit() const noexcept {
  const double off = omega() - stated_.omega;
  double sum = off * off * stated_.information();
  for (int c = 0; c < channels(); ++c)
    if (usable(c)) sum += samples(c) * std::log(std::max(variance(c), 1e-300));
  return sum;
}

void ModalFit::step_poles(double trust, double trust_omega) noexcept {
  const ModalMotion& motion = regressors_.motion();
  step_.begin(layout());
  std::optional<std::size_t> eliminated;  // the group whose linear parameters are eliminated
  for (int c = 0; c < channels(); ++c) {
    if (!usable(c) || !(variance(c) > 0)) continue;
    const double ridge = 1e-9 * samples(c);
    if (eliminated != sums_.group(c)) eliminated.reset();
    if (!eliminated && !linear_.eliminate(layout(), motion, sums_.of(c), ridge, ridge)) continue;
    eliminated = sums_.group(c);
    step_.add(layout(), motion, sums_.of(c), at(c).solution, linear_.beyond(layout()));
  }
  step_.take(layout(), motion, stated_, trust, trust_omega);
}

ModalFit::Change ModalFit::last_change() const noexcept {
  const ModalMotion& motion = regressors_.motion();
  Change change(layout().modal() + 1);
  for (std::size_t m = 0; m < motion.count(); ++m) {
    const Complex by = (step_.poles()[m] - motion.poles()[m]) / motion.size(m);
    change.segment<2>(2 * static_cast<Index>(m)) << by.real(), by.imag();
  }
  change(layout().modal()) = step_.omega() / motion.omega() - 1;
  return change;
}

Eigen::Matrix2d ModalFit::pole_covariance(std::size_t m) const noexcept {
  const double size = regressors_.motion().size(m);
  return size * size * step_.covariance(static_cast<Index>(m));
}

void ModalFit::propagate_poles(bool omega_known) noexcept {
  const ModalMotion& motion = regressors_.motion();
  std::array<bool, ModalMotion::kMaxModes> shown{};
  for (std::size_t m = 0; m < motion.count(); ++m) shown[m] = shows(m);
  errors_.begin(layout());
  for (int c = 0; c < channels(); ++c) {
    const ModalSolution& solution = at(c).solution;
    if (!solution.usable || !(solution.sigma2 > 0)) continue;
    if (!linear_.eliminate(layout(), motion, sums_.of(c), solution.prior, solution.line_prior)) continue;
    errors_.add(layout(), motion, solution, linear_, shown, at(c).errors);
    at(c).errors.known = true;
  }
  const double seen_s = std::max(1e-9, 1e-9 * static_cast<double>(newest_ns_ - t0_ns()));
  const double width = omega_known ? ModalMotion::kGiven : ModalMotion::kOpen;
  const double of_omega = omega() * omega() * stated_.information() + 1 / (width * width);
  const bool solved = errors_.solve(layout(), motion, seen_s, of_omega);
  for (PerChannel& channel : channels_) {
    channel.errors.known = channel.errors.known && solved;
    if (channel.errors.known) errors_.propagate(layout(), channel.solution, channel.errors);
  }
}

Complex ModalFit::phasor(int channel, int h) const noexcept {
  const Eigen::VectorXd& theta = at(channel).solution.theta;
  return {theta(layout().sine(h)), theta(layout().cosine(h))};
}

Complex ModalFit::amplitude(int channel, std::size_t mode) const noexcept {
  const Eigen::Vector2d a = at(channel).solution.amplitude(layout(), static_cast<Index>(mode));
  return {a(0), a(1)};
}

double ModalFit::u_amplitude(int channel, std::size_t mode) const noexcept {
  return std::sqrt(std::max(0.0, at(channel).solution.amplitude_variance(static_cast<Index>(mode))));
}

bool ModalFit::shows(std::size_t mode) const noexcept {
  const auto m = static_cast<Index>(mode);
  for (const PerChannel& channel : channels_) {
    const ModalSolution& of = channel.solution;
    if (of.usable && of.amplitude(layout(), m).squaredNorm() > kStandsOut * kStandsOut * of.amplitude_variance(m))
      return true;
  }
  return false;
}

// The χ² of the amplitudes has two degrees of freedom a channel. Chance exceeds x by exp(-x/2) Σ_{i<C} (x/2)^i / i!.
bool ModalFit::certain(std::size_t mode) const noexcept {
  const auto m = static_cast<Index>(mode);
  double half = 0.0;
  int shown = 0;
  for (int c = 0; c < channels(); ++c) {
    const ModalSolution& of = at(c).solution;
    if (!of.usable) continue;
    const Eigen::Vector2d a = of.amplitude(layout(), m);
    // An imposed motion has no transient: its prior, of width 0, leaves nothing open.
    if (!(of.covariance(2 * m, 2 * m) > kNothingOpen * of.sigma2 / samples(c))) continue;
    half += 0.5 * std::min(kSurely, a.dot(of.amplitude_covariance(m).inverse() * a));
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
  const ModalMotion& motion = regressors_.motion();
  const double u = motion.seconds(t_ns);
  Left left{0.0, 0.0, 0.0};
  Complex sum{};
  for (std::size_t m = 0; m < motion.count(); ++m) {
    if (!motion.decays(m)) continue;
    const Complex pole = motion.poles()[m];
    const Eigen::Vector2d a = of.solution.amplitude(layout(), static_cast<Index>(m));
    if (a.norm() > kStandsOut * u_amplitude(channel, m)) left.envelope += std::exp(pole.real() * u) * a.norm();
    sum += Complex{a(0), a(1)} * std::exp(pole * u);
  }
  // Swing and uncertainty are the largest over half a cycle of the drive.
  for (int angle = 0; angle < 8; ++angle) {
    const auto [swing, variance] = swing_at(of, u + angle * std::numbers::pi / 8 / omega());
    left.swing = std::max(left.swing, std::abs(swing));
    left.u = std::max(left.u, variance);
  }
  left.u = std::sqrt(std::max(0.0, left.u));
  // Modes that the data can hardly tell apart may all be uncertain while their sum is not.
  if (std::abs(sum) > kStandsOut * left.u) left.envelope = std::max(left.envelope, std::abs(sum));
  return left;
}

ModalFit::Swing ModalFit::swing_at(const PerChannel& of, double u) const noexcept {
  const ModalMotion& motion = regressors_.motion();
  const Index modal = layout().modal();
  std::array<double, 4 * ModalMotion::kMaxModes> x;
  for (std::size_t m = 0; m < motion.count(); ++m) {
    const Complex pole = motion.poles()[m], e = motion.decays(m) ? std::exp(pole * u) : Complex{};
    const std::size_t i = 2 * m, slope = static_cast<std::size_t>(modal) + i;
    x[i] = e.real();
    x[i + 1] = pole.imag() > 0 ? -e.imag() : 0.0;
    x[slope] = motion.size(m) * u * x[i];
    x[slope + 1] = motion.size(m) * u * x[i + 1];
  }
  Swing swing{0.0, 0.0};
  for (Index j = 0; j < modal; ++j)
    swing.value += of.solution.theta(layout().harmonic() + j) * x[static_cast<std::size_t>(j)];
  const Eigen::MatrixXd& covariance = of.covariance();
  const Index errors = errors_of(of);
  for (Index j = 0; j < errors; ++j) {
    double row = 0.5 * covariance(j, j) * x[static_cast<std::size_t>(j)];
    for (Index i = j + 1; i < errors; ++i) row += covariance(i, j) * x[static_cast<std::size_t>(i)];
    swing.variance += 2 * row * x[static_cast<std::size_t>(j)];
  }
  return swing;
}

double ModalFit::most(int channel, std::size_t m, std::int64_t t_ns) const noexcept {
  return std::exp(poles()[m].real() * 1e-9 * static_cast<double>(t_ns - t0_ns())) *
         (at(channel).solution.amplitude(layout(), static_cast<Index>(m)).norm() + 3 * u_amplitude(channel, m));
}

void ModalFit::overlap_at(std::int64_t t_ns, Eigen::Matrix<double, 2, Eigen::Dynamic>& B) noexcept {
  const Eigen::VectorXd& x = regressors_.at(t_ns);
  const double sine = x(layout().sine(1)), cosine = x(layout().cosine(1));
  for (Index i = 0; i < 2 * layout().modal(); ++i) {
    B(0, i) += sine * x(layout().harmonic() + i);
    B(1, i) += cosine * x(layout().harmonic() + i);
  }
}

double ModalFit::residual(int channel, std::int64_t t_ns, double value) noexcept {
  const Eigen::VectorXd& x = regressors_.at(t_ns);
  const PerChannel& of = at(channel);
  return value - sums_.reference(channel) - of.solution.theta.head(layout().linear()).dot(x.head(layout().linear()));
}

double ModalFit::disturbance(int channel, std::int64_t t_ns) noexcept {
  const Eigen::VectorXd& x = regressors_.at(t_ns);
  const ModalSolution& of = at(channel).solution;
  if (!of.usable) return 0.0;
  double sum = 0.0;
  for (Index i = layout().harmonic(); i < layout().linear(); ++i) sum += of.theta(i) * x(i);
  return sum;
}

Eigen::Matrix2d ModalFit::spread(int channel, const Eigen::Ref<const Eigen::MatrixXd>& B) const noexcept {
  Eigen::Vector2d of_sine = Eigen::Vector2d::Zero(), of_cosine = Eigen::Vector2d::Zero();
  if (usable(channel)) {
    const Eigen::MatrixXd& covariance = at(channel).covariance();  // its lower triangle
    const Index errors = errors_of(at(channel));
    for (Index j = 0; j < errors; ++j) {
      const double sine = B(0, j), cosine = B(1, j);
      const auto add = [&](Index i, double part) {
        const Eigen::Vector2d b(B.coeff(0, i), B.coeff(1, i));
        of_sine += part * (b * sine);
        of_cosine += part * (b * cosine);
      };
      for (Index i = 0; i < j; ++i) add(i, covariance.coeff(j, i));
      for (Index i = j; i < errors; ++i) add(i, covariance.coeff(i, j));
    }
  }
  Eigen::Matrix2d spread;
  spread << of_sine, of_cosine;
  return spread;
}

Eigen::Vector2d ModalFit::taken_out(int channel, const Eigen::Ref<const Eigen::MatrixXd>& B) const noexcept {
  const ModalSolution& of = at(channel).solution;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  if (!of.usable) return sum;
  for (Index i = 0; i < layout().modal(); ++i) sum += B.col(i) * of.theta(layout().harmonic() + i);
  return sum;
}

}  // namespace dwell
