#include "tests/rigsim/bent_chain.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/model/forward.hpp"

namespace rigsim {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kStepsPerPeriod = 400;
constexpr double kStepsPerHarmonic = 40;
constexpr double kStable = 0.5;   // step times the fastest rate; from 2.7 on Runge and Kutta's method diverges
constexpr double kSticks = 0.02;  // of the table's largest velocity: friction goes over within it
constexpr double kLongest_s = 60.0;
constexpr double kSettled = 12.0;  // time constants until "steady"

}  // namespace

std::string Bend::fault(const dwell::Chain& chain) const {
  const int n = chain.mass_count();
  for (const Element& of : elements)
    if (of.element < 1 || of.element > chain.element_count())
      return "friction or cubic element " + std::to_string(of.element) + ": the chain has elements 1 ... " +
             std::to_string(chain.element_count());
  for (const SideSpring& of : side)
    if (of.mass < 1 || of.mass > n || of.to < -1 || of.to > n || of.to == of.mass)
      return "side spring from mass " + std::to_string(of.mass) + ": expected two of 0 (the table), the masses 1 ... " +
             std::to_string(n) + " and ground";
  return {};
}

BentChain::BentChain(const dwell::Chain& chain, const Bend& bend, const dwell::Drive& drive, bool steady)
    : chain_(chain), bend_(bend), drive_(drive) {
  const auto n = static_cast<std::size_t>(chain.mass_count());
  choose_step();
  // At rest where the table's offset puts the linear chain.
  offset_from_ = drive.offset;
  Step first{0.0, std::vector<double>(2 * n), std::vector<double>(2 * n)};
  const dwell::SteadyResponse still = dwell::steady_response(chain, 0.0, drive.offset);
  for (std::size_t k = 0; k < n; ++k)
    if (std::isfinite(still.Y[k + 1].real())) first.state[k] = still.Y[k + 1].real();
  const double decay = dwell::slowest_decay_rate(chain);
  if (steady) drive_.ramp_s = 0.0;
  if (steady && n > 0 && decay > 0) {
    // Whole periods before 0, so that the drive passes 0 in phase.
    const double period_s = 1 / drive.frequency_hz;
    first.t_s = changed_s_ = -period_s * std::ceil(std::min(kSettled / decay, kLongest_s) / period_s);
  }
  derive(first.t_s, first.state, first.slope);
  steps_.push_back(std::move(first));
  motion_.y.resize(n + 1);
  motion_.velocity.resize(n + 1);
  motion_.acceleration.resize(n + 1);
  if (steady) advance(0.0);
}

void BentChain::choose_step() {
  const double fastest_table = std::abs(drive_.amplitude) * kTwoPi * drive_.frequency_hz;
  if (fastest_table > 0) sticks_ = kSticks * fastest_table;
  double stiffest = 0.0, dampest = 0.0;
  const auto n = static_cast<std::size_t>(chain_.mass_count());
  std::vector<double> c(n, 0.0), r(n, 0.0);
  for (std::size_t e = 0; e < chain_.stiffness.size(); ++e)
    for (const std::size_t k : {e, e + 1})  // masses are counted from 1
      if (k >= 1 && k <= n) c[k - 1] += chain_.stiffness[e], r[k - 1] += chain_.damping[e];
  for (const Bend::SideSpring& of : bend_.side)
    for (const int k : {of.mass, of.to})
      if (k >= 1) c[static_cast<std::size_t>(k - 1)] += of.stiffness, r[static_cast<std::size_t>(k - 1)] += of.damping;
  for (const Bend::Element& of : bend_.elements)
    for (const int k : {of.element - 1, of.element})
      if (k >= 1 && k <= chain_.mass_count()) r[static_cast<std::size_t>(k - 1)] += of.friction / sticks_;
  for (std::size_t k = 0; k < n; ++k) {
    stiffest = std::max(stiffest, std::sqrt(2 * c[k] / chain_.masses[k]));
    dampest = std::max(dampest, 2 * r[k] / chain_.masses[k]);
  }
  double finest = kStepsPerPeriod;  // of the drive's period
  for (const dwell::Harmonic& harmonic : drive_.harmonics)
    finest = std::max(finest, kStepsPerHarmonic * harmonic.multiple);
  step_s_ = 1 / (finest * std::max(drive_.frequency_hz, 0.1));
  if (n > 0) step_s_ = std::min(step_s_, kStable / std::max({stiffest, dampest, 1e-6}));
}

BentChain::Table BentChain::table_at(double t_s) const {
  const double since = t_s - changed_s_, drifting_s = std::max(0.0, t_s);
  // θ'' (hastening) and θ' (omega). The drift's part of θ is the same before and after a change of the drive.
  const double hastening = t_s > 0 ? kTwoPi * bend_.drift_hz : 0.0;
  const double omega = kTwoPi * drive_.frequency_hz + hastening * drifting_s;
  const double theta = phase_ + kTwoPi * drive_.frequency_hz * since + 0.5 * hastening * drifting_s * drifting_s;
  const double part = drive_.ramp_s > 0 ? std::clamp(since / drive_.ramp_s, 0.0, 1.0) : 1.0;
  const double slope = part < 1 && drive_.ramp_s > 0 ? 1 / drive_.ramp_s : 0.0;
  // The carrier, and its first two derivatives.
  std::complex<double> y = 0.0, v = 0.0, a = 0.0;
  const auto add = [&](int multiple, std::complex<double> to) {
    const auto h = static_cast<std::size_t>(multiple);
    const std::complex<double> from = h < from_.size() ? from_[h] : 0.0;
    const std::complex<double> jw{0.0, multiple * omega}, turn = std::polar(1.0, multiple * theta);
    const std::complex<double> now = from + part * (to - from), change = slope * (to - from);
    y += now * turn;
    v += (jw * now + change) * turn;
    const std::complex<double> jdw{0.0, multiple * hastening};
    a += ((jw * jw + jdw) * now + 2.0 * jw * change) * turn;
  };
  std::vector<std::complex<double>> to(from_.size());
  to.resize(std::max<std::size_t>(to.size(), 2));
  to[1] += drive_.amplitude;
  for (const dwell::Harmonic& harmonic : drive_.harmonics) {
    const auto h = static_cast<std::size_t>(harmonic.multiple);
    if (h >= to.size()) to.resize(h + 1);
    to[h] += std::polar(harmonic.amplitude, harmonic.phase_rad);
  }
  for (std::size_t h = 1; h < to.size(); ++h) add(static_cast<int>(h), to[h]);
  const double hunting = kTwoPi * bend_.hunt_hz, at = hunting * t_s;
  const double g = 1 + bend_.hunt * std::sin(at) + bend_.drift * drifting_s;
  const double dg = bend_.hunt * hunting * std::cos(at) + (t_s > 0 ? bend_.drift : 0.0);
  const double ddg = -bend_.hunt * hunting * hunting * std::sin(at);
  const double offset = offset_from_ + part * (drive_.offset - offset_from_);
  return {offset + g * y.imag(), slope * (drive_.offset - offset_from_) + g * v.imag() + dg * y.imag(),
          g * a.imag() + 2 * dg * v.imag() + ddg * y.imag()};
}

double BentChain::derive(double t_s, const std::vector<double>& state, std::vector<double>& slope) const {
  const auto n = static_cast<std::size_t>(chain_.mass_count());
  const Table table = table_at(t_s);
  const auto y = [&](std::size_t k) { return k == 0 ? table.y : state[k - 1]; };
  const auto velocity = [&](std::size_t k) { return k == 0 ? table.velocity : state[n + k - 1]; };
  std::vector<double> F(n + 1, 0.0);  // on each end, towards +y
  double ground = 0.0;
  for (std::size_t e = 0; e < chain_.stiffness.size(); ++e) {
    const bool to_ground = e == n;
    const double d = to_ground ? y(n) : y(e + 1) - y(e), v = to_ground ? velocity(n) : velocity(e + 1) - velocity(e);
    double force = chain_.stiffness[e] * d + chain_.damping[e] * v;
    for (const Bend::Element& of : bend_.elements)
      if (of.element == static_cast<int>(e) + 1) force += of.cubic * d * d * d + of.friction * std::tanh(v / sticks_);
    if (to_ground) {
      F[n] -= force;
      ground = force;
    } else {
      F[e] += force;
      F[e + 1] -= force;
    }
  }
  for (const Bend::SideSpring& of : bend_.side) {
    const auto from = static_cast<std::size_t>(of.mass);
    double d = y(from), v = velocity(from);
    if (of.to >= 0) d -= y(static_cast<std::size_t>(of.to)), v -= velocity(static_cast<std::size_t>(of.to));
    const double force = of.stiffness * d + of.damping * v;
    F[from] -= force;
    if (of.to >= 0) F[static_cast<std::size_t>(of.to)] += force;
  }
  for (std::size_t k = 0; k < n; ++k) {
    slope[k] = state[n + k];
    slope[n + k] = F[k + 1] / chain_.masses[k];
  }
  return ground;
}

void BentChain::advance(double t_s) {
  if (t_s - steps_.back().t_s > kLongest_s && t_s > 0) {
    steps_.back().t_s = t_s;
    steps_.erase(steps_.begin(), steps_.end() - 1);
    derive(t_s, steps_.back().state, steps_.back().slope);
  }
  const std::size_t size = steps_.back().state.size();
  std::vector<double> b(size), c(size), d(size), moved(size);
  while (steps_.back().t_s < t_s) {
    const Step& now = steps_.back();
    const auto ahead = [&](const std::vector<double>& slope, double by) -> const std::vector<double>& {
      for (std::size_t i = 0; i < size; ++i) moved[i] = now.state[i] + by * slope[i];
      return moved;
    };
    derive(now.t_s + step_s_ / 2, ahead(now.slope, step_s_ / 2), b);
    derive(now.t_s + step_s_ / 2, ahead(b, step_s_ / 2), c);
    derive(now.t_s + step_s_, ahead(c, step_s_), d);
    Step next{now.t_s + step_s_, now.state, std::vector<double>(size)};
    for (std::size_t i = 0; i < size; ++i) next.state[i] += step_s_ / 6 * (now.slope[i] + 2 * b[i] + 2 * c[i] + d[i]);
    derive(next.t_s, next.state, next.slope);
    steps_.push_back(std::move(next));
  }
  while (steps_.size() > 2 && steps_[1].t_s < t_s - kRemembered_s) steps_.pop_front();
}

const dwell::ChainMotion& BentChain::at(double t_s) {
  advance(t_s);
  const auto after =
      std::upper_bound(steps_.begin(), steps_.end(), t_s, [](double at, const Step& step) { return at < step.t_s; });
  const Step& b = after == steps_.end() ? steps_.back() : *after;
  const Step& a = after == steps_.begin() ? b : *std::prev(after);
  const double span = b.t_s - a.t_s, x = span > 0 ? std::clamp((t_s - a.t_s) / span, 0.0, 1.0) : 1.0;
  std::vector<double> state(a.state.size()), slope(a.state.size());
  for (std::size_t i = 0; i < state.size(); ++i)
    state[i] = (1 + 2 * x) * (1 - x) * (1 - x) * a.state[i] + x * x * (3 - 2 * x) * b.state[i] +
               span * x * (1 - x) * ((1 - x) * a.slope[i] - x * b.slope[i]);
  motion_.ground_force = derive(t_s, state, slope);
  const Table table = table_at(t_s);
  const std::size_t n = state.size() / 2;
  motion_.y[0] = table.y;
  motion_.velocity[0] = table.velocity;
  motion_.acceleration[0] = table.acceleration;
  for (std::size_t k = 0; k < n; ++k) {
    motion_.y[k + 1] = state[k];
    motion_.velocity[k + 1] = state[n + k];
    motion_.acceleration[k + 1] = slope[n + k];
  }
  return motion_;
}

// The step at t, which ends what was computed so far: what lay beyond t is dropped. To go on otherwise, change it and
// push it back once more: between two steps of the same instant nothing is interpolated.
BentChain::Step BentChain::cut(double t_s) {
  const dwell::ChainMotion now = at(t_s);
  while (!steps_.empty() && steps_.back().t_s > t_s) steps_.pop_back();
  if (!steps_.empty() && steps_.back().t_s == t_s) return steps_.back();
  Step step{t_s, {}, std::vector<double>(2 * (now.y.size() - 1))};
  step.state.assign(now.y.begin() + 1, now.y.end());
  step.state.insert(step.state.end(), now.velocity.begin() + 1, now.velocity.end());
  derive(t_s, step.state, step.slope);
  steps_.push_back(step);
  return step;
}

void BentChain::knock(double t_s, int mass, double velocity) {
  Step step = cut(t_s);
  const std::size_t n = step.state.size() / 2;
  step.state[n + static_cast<std::size_t>(mass - 1)] += velocity;
  derive(t_s, step.state, step.slope);
  steps_.push_back(std::move(step));
}

void BentChain::set_drive(double t_s, const dwell::Drive& drive) {
  Step now_step = cut(t_s);
  const double since = t_s - changed_s_;
  const double part = drive_.ramp_s > 0 ? std::clamp(since / drive_.ramp_s, 0.0, 1.0) : 1.0;
  std::vector<std::complex<double>> now(2);
  const auto add = [&](std::size_t h, std::complex<double> amplitude) {
    if (h >= now.size()) now.resize(h + 1);
    now[h] += amplitude;
  };
  for (std::size_t h = 1; h < from_.size(); ++h) add(h, (1 - part) * from_[h]);
  add(1, part * drive_.amplitude);
  for (const dwell::Harmonic& harmonic : drive_.harmonics)
    add(static_cast<std::size_t>(harmonic.multiple), std::polar(part * harmonic.amplitude, harmonic.phase_rad));
  offset_from_ += part * (drive_.offset - offset_from_);
  phase_ = std::remainder(phase_ + kTwoPi * drive_.frequency_hz * since, kTwoPi);
  from_ = std::move(now);
  changed_s_ = t_s;
  drive_ = drive;
  choose_step();
  derive(t_s, now_step.state, now_step.slope);
  steps_.push_back(std::move(now_step));
}

}  // namespace rigsim
