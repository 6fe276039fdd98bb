// The chain in time: exact displacements, velocities, accelerations and ground force at any instant, from any state,
// under a harmonic drive that may change. No step size and no step-size error: the response is the particular solution
// of the drive plus the propagated free motion.
//
// The table moves as y_0 = offset + Σ_h A_h sin(h θ + φ_h), θ' = 2πf. A change of the drive keeps θ and the state of
// the masses continuous; offset and every A_h exp(jφ_h) go over linearly within `ramp_s` (that, too, is solved
// exactly), so with a ramp the table never jumps. With ramp_s = 0 a change of amplitude lets the table jump where it
// stands; the impulse r_1 Δy_0 that an instant jump would give mass 1 is left out (no real table jumps). An undamped
// chain driven exactly at a natural frequency has no particular solution of this form: not finite then.
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
  double ramp_s = 0.0;                // within which the amplitudes go over
  std::vector<Harmonic> harmonics{};  // further parts of the table's motion
};

// SI; index 0 is the table, 1 … n the masses.
struct ChainMotion {
  std::vector<double> y;
  std::vector<double> velocity;
  std::vector<double> acceleration;
  double ground_force = 0.0;  // of element n+1 on the ground; free: 0
};

class DrivenChain {
 public:
  enum class Start { rest, steady };

  // At t = 0, θ = 0. rest: table and masses stand still at the drive's offset, then the drive begins (with its ramp);
  // steady: as if it had always been on. The chain must have no fault(). Tabulates the propagator: see propagator.hpp.
  DrivenChain(const Chain& chain, const Drive& drive, Start start);
  ~DrivenChain();
  DrivenChain(DrivenChain&&) noexcept;
  DrivenChain& operator=(DrivenChain&&) noexcept;

  // The motion at t ≥ the last change, in any order (an earlier t is answered as the last change). Valid until the next
  // call. About 2 µs for three masses, O(n²); no allocation. Bound to one thread.
  const ChainMotion& at(double t_s);

  // From t ≥ the last change on, another drive. O(n) and allocates.
  void set_drive(double t_s, const Drive& drive);

  // From t ≥ the last change on, the masses go on from this state: n displacements and n velocities. The table does not
  // change.
  void set_state(double t_s, const std::vector<double>& y, const std::vector<double>& velocity);

  // θ at t, rad.
  [[nodiscard]] double table_phase(double t_s) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell
