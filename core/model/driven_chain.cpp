#include "core/model/driven_chain.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/model/forward.hpp"
#include "core/model/propagator.hpp"

namespace dwell {
namespace {

constexpr Phasor kJ{0.0, 1.0};

// One harmonic of the table's motion: Im(shape · exp(j multiple θ)). Multiple 0 is the offset.
struct Part {
  int multiple;
  Phasor shape;
};

// The chain's answer to it within a segment: Y_k(τ) = (P_k + Q_k τ) exp(sτ), k = 0 … n, τ from the segment's start.
struct Term {
  int multiple;
  Phasor s;
  std::vector<Phasor> P, Q;
};

// A stretch of time in which every amplitude of the drive is linear in time.
struct Segment {
  double start_s = 0.0;
  double omega = 0.0;
  double theta = 0.0;  // at the start
  std::vector<Term> terms;
  Eigen::VectorXd free_motion;  // at the start: state minus particular solution
};

std::vector<Part> parts_of(const Drive& drive) {
  std::vector<Part> parts{{0, kJ * drive.offset}, {1, {drive.amplitude, 0.0}}};
  for (const Harmonic& harmonic : drive.harmonics)
    parts.push_back({harmonic.multiple, std::polar(harmonic.amplitude, harmonic.phase_rad)});
  return parts;
}

// For a table that moves as (a + bτ) exp(sτ), with D(s) = s² M + s C + K:
// D(s) Q = (c_1 + s r_1) b e_1 ,   D(s) P = (c_1 + s r_1) a e_1 + r_1 b e_1 - (2 s M + C) Q.
Term make_term(const Chain& chain, int multiple, Phasor s, Phasor a, Phasor b) {
  const std::size_t n = chain.masses.size();
  Term term{multiple, s, std::vector<Phasor>(n + 1), std::vector<Phasor>(n + 1)};
  term.P[0] = a;
  term.Q[0] = b;
  if (n == 0) return term;
  const auto Z1 = chain.stiffness[0] + s * chain.damping[0];
  std::vector<Phasor> right(n);
  if (b != 0.0) {
    right[0] = Z1 * b;
    solve_dynamic(chain, s, right);
    std::copy(right.begin(), right.end(), term.Q.begin() + 1);
    for (std::size_t k = 1; k <= n; ++k) {
      right[k - 1] = -2.0 * s * chain.masses[k - 1] * term.Q[k] - chain.damping[k - 1] * (term.Q[k] - term.Q[k - 1]);
      if (k < chain.damping.size()) right[k - 1] += chain.damping[k] * ((k < n ? term.Q[k + 1] : Phasor{}) - term.Q[k]);
    }
  }
  right[0] += Z1 * a;
  solve_dynamic(chain, s, right);
  std::copy(right.begin(), right.end(), term.P.begin() + 1);
  return term;
}

}  // namespace

struct DrivenChain::Impl {
  explicit Impl(const Chain& the_chain) : chain(the_chain), propagator(the_chain), n(the_chain.masses.size()) {
    motion.y.resize(n + 1);
    motion.velocity.resize(n + 1);
    motion.acceleration.resize(n + 1);
    state.setZero(static_cast<Eigen::Index>(2 * n));
  }

  Segment& segment_at(double t_s) { return ramp_follows && t_s >= after.start_s ? after : now; }
  const Segment& segment_at(double t_s) const { return const_cast<Impl*>(this)->segment_at(t_s); }

  // Writes the particular solution to `motion`: displacements, velocities, and the acceleration of the table alone.
  void particular(const Segment& segment, double tau) {
    std::fill(motion.y.begin(), motion.y.end(), 0.0);
    std::fill(motion.velocity.begin(), motion.velocity.end(), 0.0);
    motion.acceleration[0] = 0.0;
    for (const Term& term : segment.terms) {
      const Phasor turn = std::exp(term.s * tau);
      for (std::size_t k = 0; k <= n; ++k) {
        const Phasor Y = (term.P[k] + term.Q[k] * tau) * turn;
        motion.y[k] += Y.imag();
        motion.velocity[k] += (term.s * Y + term.Q[k] * turn).imag();
        if (k == 0) motion.acceleration[0] += (term.s * (term.s * Y + 2.0 * term.Q[k] * turn)).imag();
      }
    }
  }

  void evaluate(double t_s) {
    Segment& segment = segment_at(t_s);
    const double tau = std::max(0.0, t_s - segment.start_s);
    particular(segment, tau);
    state = segment.free_motion;
    propagator.apply(tau, state);
    for (std::size_t k = 1; k <= n; ++k) {
      motion.y[k] += state[static_cast<Eigen::Index>(k - 1)];
      motion.velocity[k] += state[static_cast<Eigen::Index>(n + k - 1)];
    }
    double left = n > 0 ? element_force(1) : 0.0;
    for (std::size_t k = 1; k <= n; ++k) {
      const double right = k < chain.stiffness.size() ? element_force(k + 1) : 0.0;
      motion.acceleration[k] = (right - left) / chain.masses[k - 1];
      left = right;
    }
    if (chain.boundary == Boundary::clamped) motion.ground_force = -element_force(n + 1);
  }

  // Force of element k on mass k-1, k = 1 …
  [[nodiscard]] double element_force(std::size_t k) const {
    const double y = k <= n ? motion.y[k] : 0.0;
    const double velocity = k <= n ? motion.velocity[k] : 0.0;
    return chain.stiffness[k - 1] * (y - motion.y[k - 1]) + chain.damping[k - 1] * (velocity - motion.velocity[k - 1]);
  }

  // A segment from start_s on: the shapes change linearly from `from` to `to` within ramp_s. With ramp_s = 0 they stay.
  Segment make_segment(double start_s, double omega, double theta, const std::vector<Part>& from,
                       const std::vector<Part>& to, double ramp_s) {
    Segment segment{start_s, omega, theta, {}, {}};
    const auto add = [&](int multiple, Phasor a, Phasor b) {
      if (a == 0.0 && b == 0.0) return;
      const Phasor turn = std::exp(kJ * (multiple * theta));
      segment.terms.push_back(make_term(chain, multiple, kJ * (multiple * omega), a * turn, b * turn));
    };
    for (const Part& part : from) add(part.multiple, part.shape, ramp_s > 0.0 ? -part.shape / ramp_s : 0.0);
    if (ramp_s > 0.0)
      for (const Part& part : to) add(part.multiple, 0.0, part.shape / ramp_s);
    return segment;
  }

  // Makes the segment continue from the masses' state in `motion`, which is overwritten.
  void join(Segment& segment) {
    state.resize(static_cast<Eigen::Index>(2 * n));
    for (std::size_t k = 1; k <= n; ++k) {
      state[static_cast<Eigen::Index>(k - 1)] = motion.y[k];
      state[static_cast<Eigen::Index>(n + k - 1)] = motion.velocity[k];
    }
    particular(segment, 0.0);
    for (std::size_t k = 1; k <= n; ++k) {
      state[static_cast<Eigen::Index>(k - 1)] -= motion.y[k];
      state[static_cast<Eigen::Index>(n + k - 1)] -= motion.velocity[k];
    }
    segment.free_motion = state;
  }

  // The shapes at t, within a ramp too.
  [[nodiscard]] std::vector<Part> shapes_at(double t_s) const {
    const Segment& segment = segment_at(t_s);
    const double tau = t_s - segment.start_s;
    std::vector<Part> shapes;
    for (const Term& term : segment.terms) {
      const Phasor shape = (term.P[0] + term.Q[0] * tau) * std::exp(-kJ * (term.multiple * segment.theta));
      const auto same =
          std::find_if(shapes.begin(), shapes.end(), [&](const Part& part) { return part.multiple == term.multiple; });
      if (same == shapes.end())
        shapes.push_back({term.multiple, shape});
      else
        same->shape += shape;
    }
    return shapes;
  }

  [[nodiscard]] double theta_at(double t_s) const {
    const Segment& segment = segment_at(t_s);
    return segment.theta + segment.omega * (t_s - segment.start_s);
  }

  // Starts another drive at t, from phase theta, shapes `from`, and the masses' state in `motion`.
  void begin(double t_s, double theta, const std::vector<Part>& from, const Drive& next) {
    drive = next;
    const double omega = 2.0 * std::numbers::pi * drive.frequency_hz;
    const std::vector<Part> to = parts_of(drive);
    ramp_follows = false;
    if (drive.ramp_s > 0.0) {
      Segment ramp = make_segment(t_s, omega, theta, from, to, drive.ramp_s);
      join(ramp);
      now = std::move(ramp);
      const double end_s = t_s + drive.ramp_s;
      evaluate(end_s);
      after = make_segment(end_s, omega, theta + omega * drive.ramp_s, to, {}, 0.0);
      join(after);
      ramp_follows = true;
    } else {
      Segment hold = make_segment(t_s, omega, theta, to, {}, 0.0);
      join(hold);
      now = std::move(hold);
    }
  }

  Chain chain;
  Propagator propagator;
  std::size_t n;
  Drive drive;  // the one set last
  Segment now, after;
  bool ramp_follows = false;
  ChainMotion motion;
  Eigen::VectorXd state;
};

DrivenChain::DrivenChain(const Chain& chain, const Drive& drive, Start start) : impl_(std::make_unique<Impl>(chain)) {
  assert(chain.fault().empty());
  if (start == Start::steady) {
    impl_->drive = drive;
    impl_->now = impl_->make_segment(0.0, 2.0 * std::numbers::pi * drive.frequency_hz, 0.0, parts_of(drive), {}, 0.0);
    impl_->now.free_motion.setZero(static_cast<Eigen::Index>(2 * impl_->n));
    return;
  }
  const std::vector<Part> standing{{0, kJ * drive.offset}};
  impl_->now = impl_->make_segment(0.0, 0.0, 0.0, standing, {}, 0.0);
  impl_->now.free_motion.setZero(static_cast<Eigen::Index>(2 * impl_->n));
  impl_->evaluate(0.0);
  impl_->begin(0.0, 0.0, standing, drive);
}

DrivenChain::~DrivenChain() = default;
DrivenChain::DrivenChain(DrivenChain&&) noexcept = default;
DrivenChain& DrivenChain::operator=(DrivenChain&&) noexcept = default;

const ChainMotion& DrivenChain::at(double t_s) {
  impl_->evaluate(t_s);
  return impl_->motion;
}

void DrivenChain::set_drive(double t_s, const Drive& drive) {
  const double from_s = std::max(t_s, impl_->now.start_s);
  const double theta = impl_->theta_at(from_s);
  const std::vector<Part> shapes = impl_->shapes_at(from_s);
  impl_->evaluate(from_s);
  impl_->begin(from_s, theta, shapes, drive);
}

void DrivenChain::set_state(double t_s, const std::vector<double>& y, const std::vector<double>& velocity) {
  assert(y.size() == impl_->n && velocity.size() == impl_->n);
  const double from_s = std::max(t_s, impl_->now.start_s);
  const double theta = impl_->theta_at(from_s);
  const std::vector<Part> shapes = impl_->shapes_at(from_s);
  std::copy(y.begin(), y.end(), impl_->motion.y.begin() + 1);
  std::copy(velocity.begin(), velocity.end(), impl_->motion.velocity.begin() + 1);
  Drive rest_of_drive = impl_->drive;
  rest_of_drive.ramp_s = impl_->ramp_follows ? std::max(0.0, impl_->after.start_s - from_s) : 0.0;
  impl_->begin(from_s, theta, shapes, rest_of_drive);
}

double DrivenChain::table_phase(double t_s) const { return impl_->theta_at(t_s); }

}  // namespace dwell
