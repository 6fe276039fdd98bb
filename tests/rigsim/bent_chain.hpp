// A chain that is more than masses, springs and dampers in a row: friction and cubic springs in its elements, springs
// beside it, and a drive whose amplitude hunts and drifts, and whose frequency drifts. Integrated in time.
//
// Element k's force: c d + r d' + cubic d³ + friction tanh(d'/v), v being 2 % of the table's largest velocity, so that
// the force has a slope. The table: offset + (1 + hunt sin 2π f_h t + drift t) Σ A_h sin(hθ + φ_h), with θ' = 2π (f +
// drift_hz t). Classical Runge-Kutta of fourth order, at least 400 steps a period; between steps cubic by values and
// slopes.
#pragma once

#include <complex>
#include <deque>
#include <vector>

#include "core/model/driven_chain.hpp"

namespace rigsim {

// Plain data; all zero: a chain that core/model/driven_chain.hpp solves exactly.
struct Bend {
  struct Element {
    int element = 1;        // k
    double friction = 0.0;  // N
    double cubic = 0.0;     // N/m³
  };
  struct SideSpring {
    int mass = 1, to = -1;  // from a mass to a mass, the table (0) or the ground (-1)
    double stiffness = 0.0, damping = 0.0;
  };
  std::vector<Element> elements;
  std::vector<SideSpring> side;
  double hunt = 0.0, hunt_hz = 0.0;
  double drift = 0.0, drift_hz = 0.0;  // growth per second from t = 0 on: part of the table's amplitude; Hz

  [[nodiscard]] bool any() const {
    return !elements.empty() || !side.empty() || hunt != 0.0 || drift != 0.0 || drift_hz != 0.0;
  }
  // What of it this chain has not ("--friction 9:1: the chain has 4 elements"), or empty.
  [[nodiscard]] std::string fault(const dwell::Chain& chain) const;
};

// Bound to one thread.
class BentChain {
 public:
  // From rest at t = 0; steady: after as long as its slowest mode needs, once the linear chain's.
  BentChain(const dwell::Chain& chain, const Bend& bend, const dwell::Drive& drive, bool steady);

  // The motion at t, not more than kRemembered before the latest t asked for. A gap of more than a minute is skipped:
  // what nobody watches stands still.
  const dwell::ChainMotion& at(double t_s);
  // From t on another drive; phase and motion go on, amplitudes go over within its ramp.
  void set_drive(double t_s, const dwell::Drive& drive);
  // At t one mass's velocity jumps by this, m/s.
  void knock(double t_s, int mass, double velocity);

  static constexpr double kRemembered_s = 2.0;

 private:
  struct Table {
    double y, velocity, acceleration;
  };
  struct Step {
    double t_s;
    std::vector<double> state;  // n displacements, n velocities
    std::vector<double> slope;
  };
  [[nodiscard]] Table table_at(double t_s) const;
  double derive(double t_s, const std::vector<double>& state, std::vector<double>& slope) const;
  void advance(double t_s);
  [[nodiscard]] Step cut(double t_s);
  void choose_step();

  dwell::Chain chain_;
  Bend bend_;
  dwell::Drive drive_;
  double changed_s_ = 0.0, phase_ = 0.0;    // of the drive: when, θ then
  std::vector<std::complex<double>> from_;  // amplitudes then, by multiple
  double offset_from_ = 0.0;
  double step_s_ = 0.0, sticks_ = 1.0;
  std::deque<Step> steps_;
  dwell::ChainMotion motion_;
};

}  // namespace rigsim
