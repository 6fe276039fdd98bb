#include "tests/study/moved.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"
#include "tests/study/bound.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

constexpr double kStandsOut = 6.0;
constexpr long kMostRows = 3000;  // of a channel's samples that stand for all, where only orders of magnitude matter

// What is taken for the drive's frequency.
double believed_omega(const Case& about) {
  return kTwoPi *
         (about.rig.excitation.reference == Reference::fixed ? about.rig.excitation.frequency_hz : about.frequency_hz);
}

// Phasors at h = 1 … 3 of every channel, readings being fitted by harmonics at their stamps.
std::vector<std::vector<Complex>> fit(const Case& about, double from_s, double seconds) {
  const double omega = believed_omega(about);
  const int H = about.rig.excitation.harmonics;
  std::vector<std::vector<Complex>> X(3);
  for (int c = 0; c < about.channels(); ++c) {
    const double rate_hz = about.lines[static_cast<std::size_t>(c)].rate_hz;
    const auto first = static_cast<std::int64_t>(std::ceil(from_s * rate_hz));
    const auto count = static_cast<std::int64_t>(seconds * rate_hz);
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * H + 1, 2 * H + 1);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(2 * H + 1), row(2 * H + 1);
    for (std::int64_t i = first; i < first + count; ++i) {
      const double t_s = instant_s(about, c, i), at = omega * (stamp_s(about, c, t_s) - from_s);
      row(0) = 1.0;
      for (int h = 1; h <= H; ++h) row(2 * h - 1) = std::sin(h * at), row(2 * h) = std::cos(h * at);
      A.selfadjointView<Eigen::Lower>().rankUpdate(row);
      b += row * reading(about, c, i, t_s);
    }
    const Eigen::VectorXd theta = A.selfadjointView<Eigen::Lower>().ldlt().solve(b);
    for (int h = 1; h <= 3; ++h)
      X[static_cast<std::size_t>(h - 1)].push_back(h <= H ? Complex{theta(2 * h - 1), theta(2 * h)} : Complex{});
  }
  return X;
}

// The same readings without noise, and without the rounding that noise would have spread.
Case quiet(const Case& about) {
  Case quiet = about;
  quiet.without_transient = true;
  for (Line& line : quiet.lines) line.sigma = line.hum = line.step = 0.0;
  return quiet;
}

// Standard uncertainty of both components of every Z: noise, and what the rig file states.
std::vector<Complex> stated_u(const Case& about, const std::vector<ElementBound>& bounds, double omega) {
  std::vector<Complex> X;
  for (int c = 0; c < about.channels(); ++c) X.push_back(about.motion->phasor(c, 1));
  const std::vector<Complex> Z = stiffness_of(about, omega, X);
  std::vector<Complex> squares;
  for (const ElementBound& bound : bounds)
    squares.emplace_back(bound.sigma_Z * bound.sigma_Z, bound.sigma_Z * bound.sigma_Z);
  const auto add = [&](double by, const std::vector<Complex>& with) {
    for (std::size_t e = 0; e < Z.size(); ++e) {
      const Complex d = by * (with[e] - Z[e]);
      squares[e] += Complex{d.real() * d.real(), d.imag() * d.imag()};
    }
  };
  const Excitation& excitation = about.rig.excitation;
  const double fixed_u =
      excitation.reference == Reference::fixed ? excitation.frequency_u_hz / excitation.frequency_hz : 0.0;
  constexpr double kSmall = 1e-6;
  add(std::hypot(excitation.clock_u, fixed_u) / kSmall, stiffness_of(about, omega * (1 + kSmall), X));
  for (const Disturbance& disturbance : about.disturbances) {
    if (disturbance.kind != Kind::stations) continue;
    std::vector<Complex> turned = X;  // one station against the other
    for (const int c : disturbance.channels) turned[static_cast<std::size_t>(c)] *= std::polar(1.0, kSmall);
    const double u_s = std::numbers::sqrt2 / std::numbers::sqrt3 * 1e-9 * about.half_ns[0];
    add(omega * u_s / kSmall, stiffness_of(about, omega, turned));
  }
  for (Complex& square : squares) square = {std::sqrt(square.real()), std::sqrt(square.imag())};
  return squares;
}

// The eigenvalues of the chain that the steady motion gives.
std::vector<Complex> eigenvalues(const Case& about, const std::vector<Complex>& Z, double omega) {
  Chain identified{about.chain.boundary, about.rig.masses, {}, {}};
  for (const Complex& of : Z) {
    identified.stiffness.push_back(of.real());
    identified.damping.push_back(of.imag() / omega);
  }
  std::vector<Complex> given;
  for (const Complex& lambda : natural_values(identified))
    if (lambda.imag() >= 0) given.push_back(lambda);
  return given;
}

Complex nearest(const std::vector<Complex>& values, Complex to) {
  return *std::min_element(values.begin(), values.end(),
                           [&](Complex a, Complex b) { return std::abs(a - to) < std::abs(b - to); });
}

// Standard uncertainty of one of these, by those of Z.
Complex uncertainty_of(const Case& about, const std::vector<Complex>& Z, const std::vector<Complex>& u, double omega,
                       Complex eigenvalue) {
  Complex squares{};
  for (std::size_t e = 0; e < Z.size(); ++e)
    for (const Complex by : {Complex{u[e].real(), 0.0}, Complex{0.0, u[e].imag()}}) {
      std::vector<Complex> other = Z;
      other[e] += by;
      const Complex moved = nearest(eigenvalues(about, other, omega), eigenvalue) - eigenvalue;
      squares += Complex{moved.real() * moved.real(), moved.imag() * moved.imag()};
    }
  return {std::sqrt(squares.real()), std::sqrt(squares.imag())};
}

// Largest shift of a pole, from the true rig to the chain that the steady motion gives, over what is resolved.
void show_poles(const Case& about, const std::vector<Complex>& Z, const std::vector<Complex>& u, double omega,
                double end_s, Moved& moved) {
  moved.by_transient = true;
  moved.shows = moved.surely = 0.0;
  if (about.chain.mass_count() == 0) return;
  std::vector<Complex> given = eigenvalues(about, Z, omega);
  const std::vector<Complex> sigma = resolved_poles(about, end_s);
  for (std::size_t m = 0; m < sigma.size() && !given.empty(); ++m) {
    const Complex truth = about.motion->natural()[m], own = nearest(given, truth), off = own - truth;
    const Complex of_chain = uncertainty_of(about, Z, u, omega, own);
    moved.shows =
        std::max({moved.shows, std::abs(off.real()) / sigma[m].real(), std::abs(off.imag()) / sigma[m].imag()});
    moved.surely = std::max({moved.surely, std::abs(off.real()) / std::hypot(sigma[m].real(), of_chain.real()),
                             std::abs(off.imag()) / std::hypot(sigma[m].imag(), of_chain.imag())});
    if (given.size() > 1) given.erase(std::find(given.begin(), given.end(), own));
  }
}

// Third harmonic of an element's force that its own deformation does not explain, over its standard deviation.
double third_shows(const Case& about, const std::vector<Complex>& X3, int k, double seconds) {
  const double omega = 3 * kTwoPi * about.frequency_hz;
  const ElementRows rows = true_rows(about, omega);
  const auto e = static_cast<std::size_t>(k - 1);
  const Complex Z{about.chain.stiffness[e], omega * about.chain.damping[e]};
  const Eigen::RowVectorXcd row = rows.force.row(k - 1) - Z * rows.deformation.row(k - 1);
  Complex force = 0.0;
  double variance = 0.0;
  for (int c = 0; c < about.channels(); ++c) {
    const Line& line = about.lines[static_cast<std::size_t>(c)];
    force += row(c) * X3[static_cast<std::size_t>(c)];
    variance += std::norm(row(c)) * line.noise() * line.noise() * 2 / (line.rate_hz * seconds);
  }
  return std::abs(force) / std::sqrt(variance);
}

}  // namespace

std::vector<Complex> resolved_poles(const Case& about, double end_s) {
  const std::vector<Complex>& poles = about.motion->natural();
  const auto M = static_cast<Eigen::Index>(poles.size());
  const int H = about.rig.excitation.harmonics;
  const double start_s = about.motion->start_s();
  const double seconds = std::min(end_s - start_s, 12 * about.motion->time_constant_s());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(2 * M, 2 * M);
  // All that is known beforehand: a pole is no further off than it is large.
  for (Eigen::Index m = 0; m < M; ++m)
    information(2 * m, 2 * m) = information(2 * m + 1, 2 * m + 1) = 1 / std::norm(poles[static_cast<std::size_t>(m)]);
  for (int c = 0; c < about.channels(); ++c) {
    const Line& line = about.lines[static_cast<std::size_t>(c)];
    const long all = std::max(1L, static_cast<long>(seconds * line.rate_hz));
    const long stride = (all + kMostRows - 1) / kMostRows, rows = all / stride;
    if (rows < 4 * M + 2 * H + 2) continue;
    Eigen::MatrixXd D = Eigen::MatrixXd::Zero(rows, 2 * M), B(rows, 2 * M + 2 * H + 1);
    const std::vector<Motion::Swing> swings = about.motion->swings(c);
    for (long i = 0; i < rows; ++i) {
      // An uneven stride, so that nothing folds.
      const double t_s = seconds * (static_cast<double>(i) + 0.5 * unit(mixed(static_cast<std::uint64_t>(i)))) /
                         static_cast<double>(rows);
      for (Eigen::Index m = 0; m < M; ++m) {
        const Complex e = std::exp(poles[static_cast<std::size_t>(m)] * t_s);
        B(i, 2 * m) = e.real();
        B(i, 2 * m + 1) = e.imag();
        for (const Motion::Swing& swing : swings) {
          if (swing.lambda != poles[static_cast<std::size_t>(m)]) continue;
          const Complex by = swing.weight * t_s * e;  // d/dλ: real part by Re λ, by Im λ it is turned
          D(i, 2 * m) = by.real();
          D(i, 2 * m + 1) = -by.imag();
        }
      }
      B(i, 2 * M) = 1.0;
      for (int h = 1; h <= H; ++h) {
        B(i, 2 * M + 2 * h - 1) = std::sin(kTwoPi * h * about.frequency_hz * t_s);
        B(i, 2 * M + 2 * h) = std::cos(kTwoPi * h * about.frequency_hz * t_s);
      }
    }
    const Eigen::MatrixXd left = D - B * B.colPivHouseholderQr().solve(D);
    information += left.transpose() * left * (static_cast<double>(stride) / (line.noise() * line.noise()));
  }
  const Eigen::MatrixXd covariance = information.ldlt().solve(Eigen::MatrixXd::Identity(2 * M, 2 * M));
  std::vector<Complex> sigma;
  for (Eigen::Index m = 0; m < M; ++m)
    sigma.emplace_back(std::sqrt(covariance(2 * m, 2 * m)), std::sqrt(covariance(2 * m + 1, 2 * m + 1)));
  return sigma;
}

bool Moved::harmless() const {
  bool any = false;
  for (std::size_t e = 0; e < c.size(); ++e) {
    if (!stands_out[e]) continue;
    any = true;
    if (!(std::abs(c[e]) < 1 && std::abs(r[e]) < 1)) return false;
  }
  return any;
}

Moved moved_by(const Case& about, double from_s, double seconds) {
  // Its transient cannot be taken out; nor is anything known of it beyond its end, where stamps may reach.
  if (about.course) from_s = about.course->end_s() - seconds - 2 * about.period_s();
  const double omega = believed_omega(about);
  const std::vector<ElementBound> bounds = bounds_of(about, seconds);
  const std::vector<std::vector<Complex>> X = fit(quiet(about), from_s, seconds);
  const std::vector<Complex> Z = stiffness_of(about, omega, X[0]), u = stated_u(about, bounds, omega);
  Moved moved;
  for (std::size_t e = 0; e < Z.size(); ++e) {
    moved.c.push_back((Z[e].real() - bounds[e].Z.real()) / u[e].real());
    moved.r.push_back((Z[e].imag() - bounds[e].Z.imag()) / u[e].imag());
    moved.stands_out.push_back(std::abs(bounds[e].d) > kStandsOut * bounds[e].sigma_d &&
                               std::abs(bounds[e].Z) > kStandsOut * std::numbers::sqrt2 * bounds[e].sigma_Z);
  }
  for (const Disturbance& disturbance : about.disturbances) {
    if (is_nonlinear(disturbance.kind))
      moved.shows = moved.surely = third_shows(about, X[2], disturbance.elements[0], seconds);
    else if (is_of_model(disturbance.kind))
      show_poles(about, Z, u, omega, from_s + seconds, moved);
  }
  return moved;
}

}  // namespace dwell::study
