// What transducers on a driven chain read, by modal superposition: steady phasors plus decaying modes, each channel's
// sum written down once and evaluated at any instant. Ten times as fast as core/model/driven_chain.hpp, from which it
// is independent and against which it is tested; and it knows the transient apart from the rest, which is what the
// study judges by.
#pragma once

#include <complex>
#include <optional>
#include <vector>

#include "core/model/chain.hpp"
#include "core/rig/rig.hpp"

namespace dwell::study {

using Complex = std::complex<double>;

// A transducer as it truly is: place and quantity, and gain, delay and low-pass with their true values.
struct Sensor {
  Quantity measures = Quantity::displacement;
  int at = 0;  // as Channel::at
  std::optional<int> relative_to;
  double gain = 1.0;
  double delay_s = 0.0;
  Filter lowpass;  // Butterworth or rc; its own settling is left aside

  // Of a motion exp(st), s in rad/s.
  [[nodiscard]] Complex response(Complex s) const;
};

// A part of the table's motion at a frequency of its own.
struct Tone {
  double frequency_hz = 0.0;
  Complex amplitude;  // m (rad)
};

// The table: y_0 = Im [Σ_h shape[h-1] exp(jhω(t - start)) + Σ tones].
struct TableMotion {
  double frequency_hz = 0.0;
  std::vector<Complex> shape;  // m (rad)
  std::vector<Tone> tones{};   // a drive whose amplitude wanders has its side bands here
};

// A spring that the chain does not know: from a mass to another mass, to the table (0) or to the ground.
struct SideSpring {
  int mass = 0;      // 1 … n
  int to = kGround;  // 0 … n, or kGround
  double stiffness = 0.0, damping = 0.0;
};

struct MassState {
  std::vector<double> y, velocity;
};

class Motion {
 public:
  Motion(const Chain& chain, const std::vector<Sensor>& sensors, const std::vector<SideSpring>& side = {});

  // From `start_s` on the table moves so. Without a state the masses go on as they move (before the first call: stand
  // still). Calls in order of time.
  void drive(double start_s, const TableMotion& table, const std::optional<MassState>& state = {});

  // The state of the masses in the steady motion of the newest drive, at its start.
  [[nodiscard]] MassState steady_state(const TableMotion& table) const;
  // The state of the masses under the newest drive.
  [[nodiscard]] MassState state(double t_s) const { return state_at(segments_.back(), t_s); }

  // A decaying oscillation that channel c alone shows, from the newest drive's start on: Re(a exp(λτ)).
  void ring(int c, Complex a, Complex lambda);

  // From t_s on mass 1 … n has a velocity more, m/s, and the table goes on as it moves. t_s: not before the newest
  // drive or knock, from which on the motion is the newest drive's.
  void knock(double t_s, int mass, double velocity);

  // Modes are left out of channel c from the instant on at which they have fallen below `negligible`.
  void prune(int c, double negligible);

  // Steady phasors Y_0 … Y_n under a table that moves with Y0.
  [[nodiscard]] std::vector<Complex> respond(double omega, Complex Y0) const;

  [[nodiscard]] double reading(int c, double t_s) const;
  // Under the newest drive: what is not its steady motion, and a bound of it from t on.
  [[nodiscard]] double transient(int c, double t_s) const;
  [[nodiscard]] double envelope(int c, double t_s) const;
  // The last instant at which |transient| exceeds `limit`, or the newest drive's start.
  [[nodiscard]] double last_above(int c, double limit) const;
  // The largest |transient| at or after t.
  [[nodiscard]] double largest_from(int c, double t_s) const;

  // Of the newest drive: channel c's reading at h times its frequency.
  [[nodiscard]] Complex phasor(int c, int h) const;
  [[nodiscard]] double start_s() const { return segments_.back().start_s; }
  // Of the slowest mode, rung ones included; 0: there is none.
  [[nodiscard]] double time_constant_s() const { return time_constant_s_; }
  // What channel c reads of each natural oscillation of the newest drive: Re Σ weight exp(λ (t - start)).
  struct Swing {
    Complex lambda, weight;
  };
  [[nodiscard]] std::vector<Swing> swings(int c) const;
  // Natural values with the table held, one of each conjugate pair.
  [[nodiscard]] const std::vector<Complex>& natural() const { return lambda_; }

 private:
  struct Mode {
    Complex lambda, weight;
    double until_s;
  };
  struct Heard {  // one channel in one segment
    std::vector<Complex> steady;
    std::vector<Complex> tones;  // as TableMotion::tones
    std::vector<Mode> modes;
  };
  struct Segment {
    double start_s, omega;
    TableMotion table;
    std::vector<Complex> amplitudes;  // of the modes, at the start
    std::vector<Heard> channels;
  };
  [[nodiscard]] TableMotion table_at(const Segment& segment, double t_s) const;  // its phases then
  [[nodiscard]] MassState state_at(const Segment& segment, double t_s) const;
  [[nodiscard]] double step_s() const;  // in which a transient cannot have moved much

  Chain chain_;
  std::vector<Sensor> sensors_;
  std::vector<SideSpring> side_;
  std::vector<Complex> lambda_;               // Im λ ≥ 0
  std::vector<std::vector<Complex>> shapes_;  // displacements of mode m, one per mass; real part, doubled for pairs
  std::vector<std::vector<Complex>> onto_;    // amplitude of mode m in a state: row of the inverse, 2n
  std::vector<Segment> segments_;
  double time_constant_s_ = 0.0, fastest_ = 0.0;
};

}  // namespace dwell::study
