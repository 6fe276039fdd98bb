#include "core/drive/seen_drive.hpp"

#include "core/base/wording.hpp"
#include "core/fit/folding.hpp"

namespace dwell {
namespace {

// Part of a folded harmonic's amplitude that irregular instants leave, above which it is named.
constexpr double kMostlyKept = 0.5;

std::string length(const Rig& rig, double amplitude) {
  return rig.motion == Motion::translation ? brief(1e3 * amplitude) + " mm" : brief(amplitude) + " rad";
}

std::string range(double low, double high, int digits) {
  const std::string from = brief(low, digits), to = brief(high, digits);
  return from == to ? from : from + " to " + to;
}

}  // namespace

std::string SeenDrive::at_rest(const Rig& rig) const {
  // The data ended while the table moved.
  if (newest_ > rig.excitation.minimum)
    return "the data end here; the table still moves, by " + length(rig, newest_) + " at the drive's frequency";
  return "the table does not move: its amplitude at the drive's frequency is " + length(rig, newest_) +
         ", the largest so far " + length(rig, largest_) + "; excitation.minimum asks for " +
         length(rig, rig.excitation.minimum);
}

std::string SeenDrive::folded_beside(const Rig& rig, double seconds, const SamplingRegularity& sampling) const {
  const double drive_hz = 0.5 * (slowest_ + fastest_);
  Folding worst;
  for (int m = rig.excitation.harmonics + 1; m <= kFoldedOrder; ++m) {
    const SamplingRegularity::Alias alias = sampling.alias(m * drive_hz, drive_hz);
    const Folding folding{m, 1, alias.apart_hz};
    const bool beats = alias.kept > kMostlyKept && alias.apart_hz * seconds >= 1.0;
    if (beats && folding.distance_hz() < worst.distance_hz()) worst = folding;
  }
  if (worst.distance_hz() >= kClearOfHarmonics * drive_hz) return "";
  return ". The sampling may be the cause: harmonic " + std::to_string(worst.harmonic) +
         " of the drive, if there is any, appears as an oscillation some " + brief(worst.apart_hz, 1) +
         " Hz beside it, so that the amplitude seems to swing. Read at another rate";
}

std::string SeenDrive::unsteady(const Rig& rig, double seconds, const SamplingRegularity& sampling) const {
  if (windows_ <= kQuarters) return "too few periods seen since the drive began";
  std::string text = "the table moves by " + length(rig, most_);
  if (fastest_ > 0) text += " at " + range(slowest_, fastest_, 4) + " Hz";
  text += ", but not steadily: in " + brief(seconds, 2) + " s its amplitude was between " +
          length(rig, std::min(least_, most_)) + " and " + length(rig, most_) + "; settling.tolerance allows " +
          brief(100 * rig.tolerance, 2) + " % of change. The search range is " +
          range(rig.excitation.search_low_hz, rig.excitation.search_high_hz, 6) + " Hz" +
          folded_beside(rig, seconds, sampling);
  return text;
}

}  // namespace dwell
