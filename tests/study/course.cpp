#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "tests/study/disturbance.hpp"

namespace dwell::study {
namespace {

// Of the velocity that element k would have if it deformed as much as the table moves: within it friction goes over
// from one sign to the other. Halved, the step must halve as well; doubled, what it dissipates is a per cent less.
constexpr double kSticks = 0.02;
constexpr double kStepsPerPeriod = 400;
constexpr double kStable = 0.5;  // step times the fastest rate; 2.7 is where Runge and Kutta's begins to diverge

struct Table {
  double y = 0.0, velocity = 0.0, acceleration = 0.0;
};

Table table_at(const TableMotion& table, double t_s) {
  Table at;
  for (std::size_t h = 1; h <= table.shape.size(); ++h) {
    const double omega = static_cast<double>(h) * kTwoPi * table.frequency_hz;
    const Complex now = table.shape[h - 1] * std::polar(1.0, omega * t_s);
    at.y += now.imag();
    at.velocity += omega * now.real();
    at.acceleration -= omega * omega * now.imag();
  }
  return at;
}

struct System {
  const Chain& chain;
  const Course::Nonlinear& nonlinear;
  const TableMotion& table;
  double sticks = 0.0;  // m/s

  // Of element k = 1 …, positive when it is stretched.
  [[nodiscard]] double force(int k, double d, double velocity) const {
    const auto e = static_cast<std::size_t>(k - 1);
    double F = chain.stiffness[e] * d + chain.damping[e] * velocity;
    if (k == nonlinear.element) F += nonlinear.cubic * d * d * d + nonlinear.friction * std::tanh(velocity / sticks);
    return F;
  }
  // state: n displacements, n velocities. Accelerations, and the force on the ground.
  double derive(double t_s, const std::vector<double>& state, std::vector<double>& slope) const {
    const auto n = static_cast<std::size_t>(chain.mass_count());
    const Table at = table_at(table, t_s);
    const auto end = [&](std::size_t k) {
      return k == 0 ? std::pair{at.y, at.velocity} : std::pair{state[k - 1], state[n + k - 1]};
    };
    std::vector<double> F(n + 2, 0.0);
    for (std::size_t k = 1; k <= n; ++k)
      F[k] = force(static_cast<int>(k), end(k).first - end(k - 1).first, end(k).second - end(k - 1).second);
    if (chain.boundary == Boundary::clamped)  // it pulls mass n back as it is stretched towards +y
      F[n + 1] = -force(static_cast<int>(n + 1), end(n).first, end(n).second);
    for (std::size_t k = 0; k < n; ++k) {
      slope[k] = state[n + k];
      slope[n + k] = (F[k + 2] - F[k + 1]) / chain.masses[k];
    }
    return -F[n + 1];
  }
};

double sensed(const Sensor& sensor, const std::vector<double>& y, const std::vector<double>& velocity,
              const std::vector<double>& acceleration, double force) {
  if (sensor.measures == Quantity::force) return sensor.gain * force;
  const std::vector<double>& of = sensor.measures == Quantity::velocity       ? velocity
                                  : sensor.measures == Quantity::acceleration ? acceleration
                                                                              : y;
  const double less = sensor.relative_to ? of[static_cast<std::size_t>(*sensor.relative_to)] : 0.0;
  return sensor.gain * (of[static_cast<std::size_t>(sensor.at)] - less);
}

}  // namespace

Course::Course(const Chain& chain, const std::vector<Sensor>& sensors, const Nonlinear& nonlinear,
               const TableMotion& table, double end_s)
    : end_s_(end_s) {
  const auto n = static_cast<std::size_t>(chain.mass_count());
  System system{chain, nonlinear, table, kSticks * kTwoPi * table.frequency_hz * std::abs(table.shape[0])};
  double fastest = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t beyond = k + 1 < chain.stiffness.size() ? k + 1 : k;
    const double damping = chain.damping[k] + chain.damping[beyond] + nonlinear.friction / system.sticks;
    fastest = std::max({fastest, 2 * std::sqrt((chain.stiffness[k] + chain.stiffness[beyond]) / chain.masses[k]),
                        2 * damping / chain.masses[k]});
  }
  step_s_ = 1 / (kStepsPerPeriod * table.frequency_hz);
  if (n > 0) step_s_ = std::min(step_s_, kStable / fastest);
  values_.resize(sensors.size());
  std::vector<double> state(2 * n, 0.0), a(2 * n), b(2 * n), c(2 * n), d(2 * n), moved(2 * n);
  const auto steps = static_cast<long>(end_s / step_s_) + 3;
  const auto ahead = [&](const std::vector<double>& slope, double by) -> const std::vector<double>& {
    for (std::size_t i = 0; i < 2 * n; ++i) moved[i] = state[i] + by * slope[i];
    return moved;
  };
  for (long step = 0; step < steps; ++step) {
    const double t_s = static_cast<double>(step) * step_s_;
    const double force = system.derive(t_s, state, a);
    const Table at = table_at(table, t_s);
    std::vector<double> y{at.y}, velocity{at.velocity}, acceleration{at.acceleration};
    y.insert(y.end(), state.begin(), state.begin() + static_cast<std::ptrdiff_t>(n));
    velocity.insert(velocity.end(), state.begin() + static_cast<std::ptrdiff_t>(n), state.end());
    acceleration.insert(acceleration.end(), a.begin() + static_cast<std::ptrdiff_t>(n), a.end());
    for (std::size_t s = 0; s < sensors.size(); ++s)
      values_[s].push_back(sensed(sensors[s], y, velocity, acceleration, force));
    system.derive(t_s + step_s_ / 2, ahead(a, step_s_ / 2), b);
    system.derive(t_s + step_s_ / 2, ahead(b, step_s_ / 2), c);
    system.derive(t_s + step_s_, ahead(c, step_s_), d);
    for (std::size_t i = 0; i < 2 * n; ++i) state[i] += step_s_ / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
}

double Course::reading(int c, double t_s) const {
  const std::vector<double>& values = values_[static_cast<std::size_t>(c)];
  const double at = std::clamp(t_s / step_s_, 1.0, static_cast<double>(values.size()) - 3.001);
  const auto i = static_cast<std::size_t>(at);
  const double x = at - static_cast<double>(i);
  // Cubic through four neighbours (Catmull and Rom): an error of third order, below 1e-6 of the amplitude at the drive.
  const double p = values[i - 1], q = values[i], r = values[i + 1], s = values[i + 2];
  return q + 0.5 * x * (r - p + x * (2 * p - 5 * q + 4 * r - s + x * (3 * (q - r) + s - p)));
}

}  // namespace dwell::study
