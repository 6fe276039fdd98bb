// Rigs with one fault each, and whether any motion names it (core/motion/missing_terms.hpp).
#pragma once

#include <cstdint>
#include <string>

#include "tests/study/any_motion.hpp"

namespace dwell::study {

enum class MissingFault : std::uint8_t {
  none,
  mass,  // these eight by 7 … 14 standard uncertainties: what is stated and what the readings leave together
  scale,
  delay,
  ground_damping,
  ground_stiffness,
  friction,
  cubic,
  reversed,  // of any channel
  swapped,
};
inline constexpr int kMissingFaults = 10;
[[nodiscard]] const char* name_of(MissingFault fault);

struct FaultOutcome {
  std::string skipped;                                          // why the rig cannot have this fault, or cannot tell it
  std::string truth;                                            // the phrase that names it
  std::string told;                                             // all that was named, and the reason
  double size = 0.0;                                            // in standard uncertainties
  bool detected = false;                                        // refused, or something is named
  bool named_some = false, named_first = false, named = false;  // anything; it, first; it, in the group
  double error = NAN;                                           // of its value, in its standard uncertainties
  double seconds = 0.0;                                         // CPU time of the estimate
};

// The rig of `index` with that fault: a start-up for what is not linear, else a table of a kind that goes with the
// index.
[[nodiscard]] FaultOutcome play_fault(MissingFault fault, std::uint64_t seed, int index, int most, double periods);

}  // namespace dwell::study
