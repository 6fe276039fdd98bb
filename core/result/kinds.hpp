// What an uncertainty comes from and of what a warning warns, as the public interface names it.
#pragma once

#include <cstdint>

namespace dwell {

// Of an entry of a budget. The comment says what BudgetShare has beside the kind.
enum class SourceKind : std::uint8_t {
  other,             // by any motion: a term that the rig file lacks
  noise,             // its channel
  transient_left,    // its channel
  quantization,      // its channel
  folded_harmonics,  // its channel: what the sampling folds onto the fundamental
  scale,             // its channel
  refresh,           // its channel: of a register that is renewed seldom
  delay,             // its channel, or its device
  lowpass,           // its channel
  highpass,          // its channel
  turnaround,        // its device
  mass,              // which
  drive_settling,    // a change of the drive while the rig settled
  change_within,     // a change within the dwell
  frequency,
  clock_rate,
  second_order,  // all sources together
};
[[nodiscard]] const char* to_string(SourceKind kind) noexcept;  // "noise", "transient left", …

enum class WarningKind : std::uint8_t {
  other,  // also: read from the result of an older program, which has the text alone
  not_settled,
  no_coefficients,
  readings,         // of one channel
  hum,              // cannot be told from a harmonic, if there is any
  folded_harmonic,  // of the drive, folds onto the fundamental, if there is any
  drive_harmonic,   // of the drive, seen and not fitted
  unsteady,         // the drive, or a channel's ratio to it
  nonlinear,        // an element, or a channel that distorts
  growing_chain,
  sync_pulses,
  any_motion,  // held against the dwell by the method of any motion
};
[[nodiscard]] const char* to_string(WarningKind kind) noexcept;  // "not settled", "no coefficients", …

}  // namespace dwell
