// What goes wrong in a dwell of the population `disturbed`: what devices do to readings, what the drive and the rig do
// that the rig file does not know of. One kind, sometimes two, per dwell, each from harmless to gross.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/study/motion.hpp"

namespace dwell::study {

enum class Kind : std::uint8_t {
  // Readings.
  refresh_one,     // one channel is refreshed slower than it is polled
  refresh_all,     // all channels of a device are
  clip_both,       // readings end at a limit on both sides
  clip_one,        // on one side
  end_codes,       // an integer type ends: its largest or smallest code, or one that says "no value"
  zeros_one,       // now and then a zero, in one channel
  zeros_all,       // … in whole scans
  repeats_one,     // now and then the reading before, in one channel
  repeats_all,     // … whole scans
  bursts,          // one channel stands still for some readings now and then
  alternate,       // every second reading of a channel is the one before
  glitch_rounded,  // coarse rounding, and one reading off its grid
  low_byte,        // the low byte of an integer is stuck
  folded,          // harmonics beyond those fitted, sampled at nearly a multiple of the drive's frequency
  stations,        // two stations behind one device, each late by what its own turnaround leaves open
  // The drive.
  fixed_off,      // the frequency is not the one given as fixed
  hunting,        // its amplitude swings
  hunting_short,  // … in dwells of few periods
  drift,          // its amplitude goes one way
  // The rig.
  friction,
  cubic,
  side_ground,   // a spring from a mass to the ground
  side_between,  // a spring between masses that are not neighbours
  mass_off,
  wrong_scale,  // a unit mistaken, or a gain that is off
  late,         // a channel is later than stated
  swapped,      // two channels stand in each other's place
  reversed,     // the load cell's sign
};
inline constexpr int kKinds = 28;
[[nodiscard]] const char* name_of(Kind kind);
// Whether the model of the rig is at fault. Such a fault must be seen where the transient, or the third harmonic of
// what is not linear, resolves it.
[[nodiscard]] bool is_of_model(Kind kind);
[[nodiscard]] inline bool is_nonlinear(Kind kind) { return kind == Kind::friction || kind == Kind::cubic; }

// One of a dwell's disturbances, for people and for the judge.
struct Disturbance {
  Kind kind = Kind::refresh_one;
  std::string told;           // with its strength
  std::vector<int> channels;  // disturbed ones
  std::vector<int> elements;  // disturbed ones, k = 1 …
};

// What a device makes of one channel's readings; applied in this order.
struct Mishap {
  double repeats = 0.0;      // part of the readings that are the one before
  double bursts = 0.0;       // part of the cells of kBurstCell readings that hold a burst of …
  int burst_length = 0;      // … so many equal readings
  bool alternate = false;    // every second reading is the one before
  bool whole_scans = false;  // repeats and zeros befall all channels of the same poll alike
  double refresh_s = 0.0;    // the device takes a new value this often; 0: when asked
  double refresh_phase_s = 0.0;
  double low = -INFINITY, high = INFINITY;  // of a reading as given
  double low_code = NAN, high_code = NAN;   // given in place of a reading beyond, instead of the limit itself
  double low_byte_step = 0.0;               // of the integer whose low byte is stuck; 0: none is
  int low_byte = 0;
  double zeros = 0.0;  // part of the readings
  double codes = 0.0;  // part of the readings that are `code`
  double code = 0.0;
  std::int64_t glitch = -1;  // index of the one reading that is off by …
  double glitch_by = 0.0;
};
inline constexpr int kBurstCell = 64;

// A chain with friction and a cubic spring in one element, by integration in time: what its channels read. n = 0:
// exact, without integration.
class Course {
 public:
  struct Nonlinear {
    int element = 1;        // k
    double friction = 0.0;  // N
    double cubic = 0.0;     // N/m³
  };
  // From rest at t = 0 on to `end_s`, the table moving as given. The chain is classical Runge-Kutta of fourth order,
  // with
  // steps of a 400th of the drive's period or finer; friction goes over within 2 % of the velocity's amplitude.
  Course(const Chain& chain, const std::vector<Sensor>& sensors, const Nonlinear& nonlinear, const TableMotion& table,
         double end_s);
  [[nodiscard]] double reading(int c, double t_s) const;
  [[nodiscard]] double end_s() const { return end_s_; }

 private:
  double step_s_ = 0.0, end_s_ = 0.0;
  std::vector<std::vector<double>> values_;  // per channel, per step
};

}  // namespace dwell::study
