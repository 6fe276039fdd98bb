// Readings of a chain that has what its rig file does not: a spring or damper from a mass to ground, a spring
// between the table or another mass and a mass, friction and a cubic stiffness of an element. Integrated by Runge and
// Kutta's method of fourth order, a step per millisecond or less; at 4 Hz and rates up to 100 per s that is 1e-6 of the
// motion.
#pragma once

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/model/chain.hpp"
#include "core/motion/likelihood.hpp"

namespace dwell {

struct Faults {
  int mass = 1;  // joined to the ground by …
  double ground_stiffness = 0.0, ground_damping = 0.0;
  double table_stiffness = 0.0;  // … and to the table, or to joined_to
  int element = 1;               // with …
  double friction = 0.0, cubic = 0.0;
  int joined_to = 0;  // where table_stiffness ends: the table, or another mass
};

class FaultyMotion {
 public:
  // A sine of the table, begun at 0.
  struct Tone {
    double hz, part;  // of the amplitude
  };
  // From rest.
  FaultyMotion(const Chain& chain, const Faults& faults, double amplitude,
               std::vector<Tone> table = {{4.0, 1.0}, {2.7, 0.4}, {6.1, 0.3}})
      : chain_(chain),
        faults_(faults),
        amplitude_(amplitude),
        table_(std::move(table)),
        x_(2 * chain.masses.size(), 0.0) {}

  // Displacements and velocities of table and masses and the force on the ground, at an instant not before the last.
  struct State {
    std::vector<double> y, velocity;
    double force = 0.0;
  };
  State at(double t_s) {
    while (now_s_ < t_s) step(std::min(kStep_s, t_s - now_s_));
    State out = state(now_s_, x_);
    if (chain_.boundary == Boundary::clamped) {
      const std::size_t n = chain_.masses.size();
      out.force = -force(static_cast<int>(n) + 1, -out.y[n], -out.velocity[n]);
    }
    return out;
  }

 private:
  static constexpr double kStep_s = 5e-4;
  [[nodiscard]] State state(double t_s, const std::vector<double>& x) const {
    State out{{0.0}, {0.0}, 0.0};
    for (const Tone& tone : table_) {
      const double w = kTwoPi * tone.hz;
      out.y[0] += amplitude_ * tone.part * std::sin(w * t_s);
      out.velocity[0] += amplitude_ * tone.part * w * std::cos(w * t_s);
    }
    const std::size_t n = chain_.masses.size();
    for (std::size_t k = 0; k < n; ++k) {
      out.y.push_back(x[k]);
      out.velocity.push_back(x[n + k]);
    }
    return out;
  }
  [[nodiscard]] double force(int k, double d, double v) const {
    const auto e = static_cast<std::size_t>(k - 1);
    double F = chain_.stiffness[e] * d + chain_.damping[e] * v;
    if (k == faults_.element) F += faults_.cubic * d * d * d + faults_.friction * std::tanh(v / 1e-3);
    return F;
  }
  [[nodiscard]] double joined(const State& now) const { return now.y[static_cast<std::size_t>(faults_.joined_to)]; }
  [[nodiscard]] std::vector<double> slope(double t_s, const std::vector<double>& x) const {
    const State now = state(t_s, x);
    const std::size_t n = chain_.masses.size();
    std::vector<double> out(2 * n), F(n + 2, 0.0);
    for (std::size_t k = 1; k <= n; ++k)
      F[k] = force(static_cast<int>(k), now.y[k] - now.y[k - 1], now.velocity[k] - now.velocity[k - 1]);
    if (chain_.boundary == Boundary::clamped) F[n + 1] = force(static_cast<int>(n) + 1, -now.y[n], -now.velocity[n]);
    for (std::size_t k = 0; k < n; ++k) {
      double sum = F[k + 2] - F[k + 1];
      if (static_cast<int>(k) + 1 == faults_.mass)
        sum -= faults_.ground_stiffness * now.y[k + 1] + faults_.ground_damping * now.velocity[k + 1] +
               faults_.table_stiffness * (now.y[k + 1] - joined(now));
      if (faults_.joined_to > 0 && static_cast<int>(k) + 1 == faults_.joined_to)
        sum += faults_.table_stiffness * (now.y[static_cast<std::size_t>(faults_.mass)] - joined(now));
      out[k] = x[n + k];
      out[n + k] = sum / chain_.masses[k];
    }
    return out;
  }
  void step(double h) {
    const auto moved = [&](const std::vector<double>& by, double part) {
      std::vector<double> x = x_;
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += part * by[i];
      return x;
    };
    const auto a = slope(now_s_, x_), b = slope(now_s_ + h / 2, moved(a, h / 2)),
               c = slope(now_s_ + h / 2, moved(b, h / 2)), d = slope(now_s_ + h, moved(c, h));
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    now_s_ += h;
  }

  Chain chain_;
  Faults faults_;
  double amplitude_, now_s_ = 0.0;
  std::vector<Tone> table_;
  std::vector<double> x_;
};

// What displacement transducers and a load cell read of it, noise sigma[c] added, all channels at the same instants.
inline MotionData readings_of(const Rig& rig, FaultyMotion motion, double until_s, double rate_hz,
                              const std::vector<double>& sigma, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  MotionData data;
  for (int i = 0; i / rate_hz < until_s; ++i) {
    const auto state = motion.at(i / rate_hz);
    for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c) {
      const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
      const double value =
          channel.measures == Quantity::force ? state.force : state.y[static_cast<std::size_t>(channel.at)];
      data.readings.push_back({to_ns(i / rate_hz), c, value + sigma[static_cast<std::size_t>(c)] * normal(rng)});
    }
  }
  return data;
}

}  // namespace dwell
