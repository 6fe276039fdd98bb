// Kinds of sources of uncertainty and kinds of warnings, with the names that the public interface gives them.
#pragma once

#include <cstdint>

namespace dwell {

// Kinds of the entries of a budget. Those from `noise` to `highpass` are of one channel, which BudgetShare names; a
// delay may be of a device instead, uneven readings of several channels.
enum class SourceKind : std::uint8_t {
  other,  // by any motion: a term that the rig file lacks
  noise,
  transient_left,
  quantization,
  folded_harmonics,  // harmonics of the drive that the sampling folds onto the fundamental
  scale,
  refresh,  // of a register that is renewed seldom
  uneven,   // errors of readings that grow with the motion
  delay,
  lowpass,
  highpass,
  turnaround,      // of a device, which BudgetShare names
  mass,            // BudgetShare has its number
  drive_settling,  // a change of the drive while the rig settled
  change_within,   // a change within the dwell
  frequency,
  clock_rate,
  second_order,  // all sources together
};
[[nodiscard]] const char* to_string(SourceKind kind) noexcept;  // "noise", "transient left", …

enum class WarningKind : std::uint8_t {
  other,  // also of results of older programs, which hold the text alone
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
