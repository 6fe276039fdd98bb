#include "tests/study/motion.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"

namespace dwell::study {
namespace {

constexpr Complex kJ{0.0, 1.0};

Complex lowpass_response(const Filter& filter, Complex s) {
  if (filter.kind == FilterKind::none) return 1.0;
  s /= kTwoPi * filter.hz;
  if (filter.kind == FilterKind::rc) return std::pow(1.0 / (1.0 + s), filter.order);
  // Butterworth: quadratic factors s² + 2 sin((2k+1)π/2N) s + 1, and s + 1 where N is odd.
  Complex denominator = filter.order % 2 == 1 ? 1.0 + s : 1.0;
  for (int k = 0; k < filter.order / 2; ++k)
    denominator *= s * s + 2 * std::sin((2 * k + 1) * std::numbers::pi / (2 * filter.order)) * s + 1.0;
  return 1.0 / denominator;
}

// Adds a spring and damper between masses a and b (0 … n-1; otherwise: not a mass) to the scaled matrices.
void join(const Chain& chain, int a_end, int b_end, double stiffness, double damping, Eigen::MatrixXd& K,
          Eigen::MatrixXd& C) {
  const int n = chain.mass_count();
  for (const int a : {a_end, b_end})
    for (const int b : {a_end, b_end}) {
      if (a < 0 || b < 0 || a >= n || b >= n) continue;
      const double root =
          std::sqrt(chain.masses[static_cast<std::size_t>(a)] * chain.masses[static_cast<std::size_t>(b)]);
      const double sign = a == b ? 1.0 : -1.0;
      K(a, b) += sign * stiffness / root;
      C(a, b) += sign * damping / root;
    }
}

// What a sensor makes of displacements y_1 … y_n (and y_0) that move as exp(st).
Complex sensed(const Chain& chain, const Sensor& sensor, const std::vector<Complex>& y, Complex s) {
  if (sensor.measures == Quantity::force) {
    const auto last = static_cast<std::size_t>(chain.mass_count());
    return (chain.stiffness[last] + s * chain.damping[last]) * y[last];
  }
  Complex seen = y[static_cast<std::size_t>(sensor.at)];
  if (sensor.relative_to) seen -= y[static_cast<std::size_t>(*sensor.relative_to)];
  if (sensor.measures == Quantity::velocity) seen *= s;
  if (sensor.measures == Quantity::acceleration) seen *= s * s;
  return seen;
}

}  // namespace

Complex Sensor::response(Complex s) const { return gain * std::exp(-s * delay_s) * lowpass_response(lowpass, s); }

Motion::Motion(const Chain& chain, const std::vector<Sensor>& sensors, const std::vector<SideSpring>& side)
    : chain_(chain), sensors_(sensors), side_(side) {
  const int n = chain.mass_count();
  if (n == 0) return;
  // Time in units of 1/omega0 and masses scaled to one: entries near one, whatever the units.
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n), C = K;
  for (int e = 0; e < chain.element_count(); ++e)
    join(chain, e - 1, e, chain.stiffness[static_cast<std::size_t>(e)], chain.damping[static_cast<std::size_t>(e)], K,
         C);
  for (const SideSpring& spring : side)
    join(chain, spring.mass - 1, spring.to - 1, spring.stiffness, spring.damping, K, C);
  const double omega0 = std::sqrt(K.diagonal().maxCoeff());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  A.topRightCorner(n, n).setIdentity();
  A.bottomLeftCorner(n, n) = -K / (omega0 * omega0);
  A.bottomRightCorner(n, n) = -C / omega0;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(A);
  const Eigen::MatrixXcd V = solver.eigenvectors(), inverse = V.inverse();
  for (int m = 0; m < 2 * n; ++m) {
    const Complex lambda = solver.eigenvalues()(m) * omega0;
    if (lambda.imag() < 0) continue;
    lambda_.push_back(lambda);
    const double both = lambda.imag() > 0 ? 2.0 : 1.0;
    std::vector<Complex> shape, onto;
    for (int k = 0; k < n; ++k) shape.push_back(both * V(k, m) / std::sqrt(chain.masses[static_cast<std::size_t>(k)]));
    for (int k = 0; k < 2 * n; ++k) {
      const double root = std::sqrt(chain.masses[static_cast<std::size_t>(k % n)]);
      onto.push_back(inverse(m, k) * root / (k < n ? 1.0 : omega0));
    }
    shapes_.push_back(std::move(shape));
    onto_.push_back(std::move(onto));
    time_constant_s_ = std::max(time_constant_s_, -1.0 / lambda.real());
    fastest_ = std::max(fastest_, std::abs(lambda));
  }
}

std::vector<Complex> Motion::respond(double omega, Complex Y0) const {
  if (side_.empty()) return steady_response(chain_, omega, Y0).Y;
  const int n = chain_.mass_count();
  Eigen::MatrixXcd D = Eigen::MatrixXcd::Zero(n + 1, n + 1);  // of the table and the masses
  const auto add = [&](int a, int b, Complex Z) {
    D(a, a) += Z;
    if (b < 0 || b > n) return;
    D(b, b) += Z;
    D(a, b) -= Z;
    D(b, a) -= Z;
  };
  for (int e = 0; e < chain_.element_count(); ++e)
    add(e, e + 1, {chain_.stiffness[static_cast<std::size_t>(e)], omega * chain_.damping[static_cast<std::size_t>(e)]});
  for (const SideSpring& spring : side_) add(spring.mass, spring.to, {spring.stiffness, omega * spring.damping});
  for (int k = 1; k <= n; ++k) D(k, k) -= omega * omega * chain_.masses[static_cast<std::size_t>(k - 1)];
  const Eigen::VectorXcd y = D.bottomRightCorner(n, n).partialPivLu().solve(-D.bottomLeftCorner(n, 1) * Y0);
  std::vector<Complex> Y{Y0};
  Y.insert(Y.end(), y.begin(), y.end());
  return Y;
}

MassState Motion::steady_state(const TableMotion& table) const {
  const auto n = static_cast<std::size_t>(chain_.mass_count());
  MassState state{std::vector<double>(n), std::vector<double>(n)};
  const auto add = [&](double omega, Complex Y0) {
    const std::vector<Complex> Y = respond(omega, Y0);
    for (std::size_t k = 0; k < n; ++k) {
      state.y[k] += Y[k + 1].imag();
      state.velocity[k] += (kJ * omega * Y[k + 1]).imag();
    }
  };
  for (std::size_t h = 1; h <= table.shape.size(); ++h)
    add(static_cast<double>(h) * kTwoPi * table.frequency_hz, table.shape[h - 1]);
  for (const Tone& tone : table.tones) add(kTwoPi * tone.frequency_hz, tone.amplitude);
  return state;
}

TableMotion Motion::table_at(const Segment& segment, double t_s) const {
  const double tau = t_s - segment.start_s;
  TableMotion table = segment.table;
  for (std::size_t h = 0; h < table.shape.size(); ++h)
    table.shape[h] *= std::exp(kJ * (static_cast<double>(h + 1) * segment.omega * tau));
  for (Tone& tone : table.tones) tone.amplitude *= std::exp(kJ * (kTwoPi * tone.frequency_hz * tau));
  return table;
}

void Motion::knock(double t_s, int mass, double velocity) {
  MassState state = state_at(segments_.back(), t_s);
  state.velocity[static_cast<std::size_t>(mass - 1)] += velocity;
  drive(t_s, table_at(segments_.back(), t_s), state);
}

MassState Motion::state_at(const Segment& segment, double t_s) const {
  const double tau = t_s - segment.start_s;
  MassState state = steady_state(table_at(segment, t_s));
  for (std::size_t m = 0; m < lambda_.size(); ++m) {
    const Complex now = segment.amplitudes[m] * std::exp(lambda_[m] * tau);
    for (std::size_t k = 0; k < state.y.size(); ++k) {
      state.y[k] += (shapes_[m][k] * now).real();
      state.velocity[k] += (lambda_[m] * shapes_[m][k] * now).real();
    }
  }
  return state;
}

void Motion::drive(double start_s, const TableMotion& table, const std::optional<MassState>& given) {
  const auto n = static_cast<std::size_t>(chain_.mass_count());
  MassState state{std::vector<double>(n), std::vector<double>(n)};
  if (given)
    state = *given;
  else if (!segments_.empty())
    state = state_at(segments_.back(), start_s);
  const MassState steady = steady_state(table);
  Segment segment{start_s, kTwoPi * table.frequency_hz, table, {}, {}};
  for (const std::vector<Complex>& onto : onto_) {
    Complex amplitude = 0.0;
    for (std::size_t k = 0; k < n; ++k)
      amplitude += onto[k] * (state.y[k] - steady.y[k]) + onto[n + k] * (state.velocity[k] - steady.velocity[k]);
    segment.amplitudes.push_back(amplitude);
  }
  segment.channels.resize(sensors_.size());
  const auto heard = [&](double f_hz, Complex Y0, std::vector<Complex> Heard::*of) {
    const std::vector<Complex> Y = respond(kTwoPi * f_hz, Y0);
    for (std::size_t c = 0; c < sensors_.size(); ++c)
      (segment.channels[c].*of)
          .push_back(sensed(chain_, sensors_[c], Y, kJ * (kTwoPi * f_hz)) * sensors_[c].response(kJ * (kTwoPi * f_hz)));
  };
  for (std::size_t h = 1; h <= table.shape.size(); ++h)
    heard(static_cast<double>(h) * table.frequency_hz, table.shape[h - 1], &Heard::steady);
  for (const Tone& tone : table.tones) heard(tone.frequency_hz, tone.amplitude, &Heard::tones);
  for (std::size_t m = 0; m < lambda_.size(); ++m) {
    std::vector<Complex> y(n + 1);
    for (std::size_t k = 0; k < n; ++k) y[k + 1] = shapes_[m][k] * segment.amplitudes[m];
    for (std::size_t c = 0; c < sensors_.size(); ++c) {
      const Complex weight = sensors_[c].response(lambda_[m]) * sensed(chain_, sensors_[c], y, lambda_[m]);
      if (weight != 0.0) segment.channels[c].modes.push_back({lambda_[m], weight, INFINITY});
    }
  }
  segments_.push_back(std::move(segment));
}

void Motion::ring(int c, Complex a, Complex lambda) {
  segments_.back().channels[static_cast<std::size_t>(c)].modes.push_back({lambda, a, INFINITY});
  time_constant_s_ = std::max(time_constant_s_, -1.0 / lambda.real());
  fastest_ = std::max(fastest_, std::abs(lambda));
}

void Motion::prune(int c, double negligible) {
  for (Segment& segment : segments_) {
    std::vector<Mode>& modes = segment.channels[static_cast<std::size_t>(c)].modes;
    for (Mode& mode : modes)
      mode.until_s =
          segment.start_s + std::max(0.0, std::log(std::abs(mode.weight) / negligible) / -mode.lambda.real());
  }
}

double Motion::reading(int c, double t_s) const {
  std::size_t newest = segments_.size() - 1;
  while (newest > 0 && t_s < segments_[newest].start_s) --newest;
  const Segment& segment = segments_[newest];
  const Heard& heard = segment.channels[static_cast<std::size_t>(c)];
  const double tau = t_s - segment.start_s;
  const double turn_re = std::cos(segment.omega * tau), turn_im = std::sin(segment.omega * tau);
  double sum = 0.0, re = 1.0, im = 0.0;
  for (const Complex& X : heard.steady) {
    const double next = re * turn_re - im * turn_im;
    im = re * turn_im + im * turn_re;
    re = next;
    sum += X.real() * im + X.imag() * re;
  }
  for (std::size_t i = 0; i < heard.tones.size(); ++i)
    sum += (heard.tones[i] * std::polar(1.0, kTwoPi * segment.table.tones[i].frequency_hz * tau)).imag();
  for (const Mode& mode : heard.modes)
    if (t_s < mode.until_s) {
      const double angle = mode.lambda.imag() * tau;
      sum += std::exp(mode.lambda.real() * tau) *
             (mode.weight.real() * std::cos(angle) - mode.weight.imag() * std::sin(angle));
    }
  return sum;
}

double Motion::transient(int c, double t_s) const {
  const Segment& segment = segments_.back();
  double sum = 0.0;
  for (const Mode& mode : segment.channels[static_cast<std::size_t>(c)].modes)
    sum += (mode.weight * std::exp(mode.lambda * (t_s - segment.start_s))).real();
  return sum;
}

double Motion::envelope(int c, double t_s) const {
  const Segment& segment = segments_.back();
  double sum = 0.0;
  for (const Mode& mode : segment.channels[static_cast<std::size_t>(c)].modes)
    sum += std::abs(mode.weight) * std::exp(mode.lambda.real() * (t_s - segment.start_s));
  return sum;
}

std::vector<Motion::Swing> Motion::swings(int c) const {
  std::vector<Swing> swings;
  for (const Mode& mode : segments_.back().channels[static_cast<std::size_t>(c)].modes)
    swings.push_back({mode.lambda, mode.weight});
  return swings;
}

double Motion::step_s() const { return kTwoPi / std::max(fastest_, 1e-9) / 24; }

double Motion::last_above(int c, double limit) const {
  const double start = start_s();
  if (!(envelope(c, start) > limit)) return start;
  double low = start, high = start + time_constant_s_;
  while (envelope(c, high) > limit) low = high, high += time_constant_s_;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (envelope(c, middle) > limit ? low : high) = middle;
  }
  for (double t = high; t > start; t -= step_s())
    if (std::abs(transient(c, t)) > limit) return t;
  return start;
}

double Motion::largest_from(int c, double t_s) const {
  double largest = std::abs(transient(c, t_s));
  for (double t = t_s + step_s(); envelope(c, t) > largest * (1 + 1e-9); t += step_s())
    largest = std::max(largest, std::abs(transient(c, t)));
  return largest;
}

Complex Motion::phasor(int c, int h) const {
  const std::vector<Complex>& steady = segments_.back().channels[static_cast<std::size_t>(c)].steady;
  return h <= static_cast<int>(steady.size()) ? steady[static_cast<std::size_t>(h - 1)] : Complex{};
}

}  // namespace dwell::study
