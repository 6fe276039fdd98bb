// How good the coefficients of any motion are (core/motion), on the random rigs of the study.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/motion/motion_recorder.hpp"
#include "tests/study/case.hpp"

namespace dwell::study {

// What the table does. All but `dwell` are sums of tones: exact, and of any shape.
enum class TableKind {
  dwell,   // a steady drive begun at rest, from any state or after a change: the population `white`
  ramp,    // a sine whose amplitude rises from 0 and falls again, within 4 … 20 periods each
  random,  // 40 tones of any phase between 0.2 and 2.5 times the drive
  wander,  // a sine whose amplitude wanders by 10 % and whose phase does by 0.1 rad
  sparse,  // the drive alone, with another tone, as a swell, or eight tones instead; 5 … 14 readings of each channel a
           // period, noise of 1 … 2 %, none or one mass
};
inline constexpr int kTableKinds = 5, kReadOften = 4;  // all; all but `sparse`
[[nodiscard]] const char* name_of(TableKind kind);

// A rig of at most `most` masses; index draws it, with the seed.
[[nodiscard]] Case draw_motion_case(TableKind kind, std::uint64_t seed, int index, int most);

// The readings up to then, as the method takes them.
[[nodiscard]] MotionRecorder recorded(const Case& about, double until_s);

struct MotionOutcome {
  std::string reason;          // why there is no estimate
  bool refused = false;        // that the readings contradict the model
  std::vector<double> errors;  // (value - truth) / u, of c and r of all elements that are reported
  std::vector<double> beyond;  // |value - truth| / U95, likewise
  int withheld = 0;            // elements that are not identifiable
  int widened = 0;             // 1: a warning says that uncertainties are widened
  int advised = 0;             // 1: something is named as missing
  double seconds = 0.0;        // CPU time of this estimate
};

// Estimates from the first `periods` periods.
[[nodiscard]] MotionOutcome play_motion(const Case& about, double periods);

}  // namespace dwell::study
