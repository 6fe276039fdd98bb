#include "core/result/kinds.hpp"

namespace dwell {

const char* to_string(SourceKind kind) noexcept {
  switch (kind) {
    case SourceKind::other:
      return "other";
    case SourceKind::noise:
      return "noise";
    case SourceKind::transient_left:
      return "transient left";
    case SourceKind::quantization:
      return "quantization";
    case SourceKind::folded_harmonics:
      return "folded harmonics";
    case SourceKind::scale:
      return "scale";
    case SourceKind::refresh:
      return "refresh";
    case SourceKind::uneven:
      return "uneven readings";
    case SourceKind::delay:
      return "delay";
    case SourceKind::lowpass:
      return "low-pass";
    case SourceKind::highpass:
      return "high-pass";
    case SourceKind::turnaround:
      return "turnaround";
    case SourceKind::mass:
      return "mass";
    case SourceKind::drive_settling:
      return "drive while settling";
    case SourceKind::change_within:
      return "change within the dwell";
    case SourceKind::frequency:
      return "frequency";
    case SourceKind::clock_rate:
      return "clock rate";
    case SourceKind::second_order:
      return "second order";
  }
  return "other";
}

const char* to_string(WarningKind kind) noexcept {
  switch (kind) {
    case WarningKind::other:
      return "other";
    case WarningKind::not_settled:
      return "not settled";
    case WarningKind::no_coefficients:
      return "no coefficients";
    case WarningKind::readings:
      return "readings";
    case WarningKind::hum:
      return "hum";
    case WarningKind::folded_harmonic:
      return "folded harmonic";
    case WarningKind::drive_harmonic:
      return "drive harmonic";
    case WarningKind::unsteady:
      return "unsteady";
    case WarningKind::nonlinear:
      return "nonlinear";
    case WarningKind::growing_chain:
      return "growing chain";
    case WarningKind::sync_pulses:
      return "sync pulses";
    case WarningKind::any_motion:
      return "any motion";
  }
  return "other";
}

}  // namespace dwell
