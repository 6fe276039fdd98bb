// Motion of a chain in time, exact at any instant, from any state, under a harmonic drive that may change. The response
// is the drive's particular solution plus the propagated free motion: no step size, and no error from one.
//
// The table moves as y_0 = offset + Σ_h A_h sin(h θ + φ_h), θ' = 2πf. A change of the drive keeps θ and the masses'
// state continuous. The offset and every A_h exp(jφ_h) change linearly within `ramp_s`; this is solved exactly too.
// With ramp_s = 0 the table jumps when its amplitude changes. The impulse r_1 Δy_0 of such a jump on mass 1 is left
// out, since no real table jumps. An undamped chain driven exactly at a natural frequency has no such particular
// solution: the motion is not finite.
#pragma once

#include <memory>
#include <vector>

#include "core/model/chain.hpp"

namespace dwell {

struct Harmonic {
  int multiple = 2;        // of the drive's frequency, ≥ 1
  double amplitude = 0.0;  // m (rad)
  double phase_rad = 0.0;
};

struct Drive {
  double frequency_hz = 0.0;          // ≥ 0
  double amplitude = 0.0;             // A_1 with φ_1 = 0, m (rad)
  double offset = 0.0;                // m (rad)
  double ramp_s = 0.0;                // duration of the change to these amplitudes
  std::vector<Harmonic> harmonics{};  // further parts of the table's motion
};

// SI units. Index 0 is the table, 1 … n are the masses.
struct ChainMotion {
  std::vector<double> y;
  std::vector<double> velocity;
  std::vector<double> acceleration;
  double ground_force = 0.0;  // of element n+1 on the ground, + when mass n is displaced in +; free: 0
};

class DrivenChain {
 public:
  enum class Start { rest, steady };

  // Begins at t = 0 with θ = 0. rest: table and masses stand still at the drive's offset, then the drive begins, with
  // its ramp. steady: the drive has always been on. The chain must have no fault(). For the cost see propagator.hpp.
  DrivenChain(const Chain& chain, const Drive& drive, Start start);
  ~DrivenChain();
  DrivenChain(DrivenChain&&) noexcept;
  DrivenChain& operator=(DrivenChain&&) noexcept;

  // The motion at t, in any order of t. A t before the last change returns the motion at that change. The reference is
  // valid until the next call. About 2 µs for three masses, O(n²); no allocation. Bound to one thread.
  const ChainMotion& at(double t_s);

  // Changes to another drive at t. A t before the last change counts as that change. O(n²), allocates.
  void set_drive(double t_s, const Drive& drive);

  // Sets the masses' state at t, as set_drive(): n displacements and n velocities, SI. The table's motion is unchanged.
  void set_state(double t_s, const std::vector<double>& y, const std::vector<double>& velocity);

  // θ at t, rad.
  [[nodiscard]] double table_phase(double t_s) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell
