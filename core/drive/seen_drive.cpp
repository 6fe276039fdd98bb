#include "core/drive/seen_drive.hpp"

#include "core/base/wording.hpp"

namespace dwell {
namespace {

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

std::string SeenDrive::unsteady(const Rig& rig, double seconds) const {
  if (windows_ <= kQuarters) return "too few periods seen since the drive began";
  std::string text = "the table moves by " + length(rig, most_);
  if (fastest_ > 0) text += " at " + range(slowest_, fastest_, 4) + " Hz";
  text += ", but not steadily: in " + brief(seconds, 2) + " s its amplitude was between " +
          length(rig, std::min(least_, most_)) + " and " + length(rig, most_) + "; settling.tolerance allows " +
          brief(100 * rig.tolerance, 2) + " % of change. The search range is " +
          range(rig.excitation.search_low_hz, rig.excitation.search_high_hz, 6) + " Hz";
  return text;
}

}  // namespace dwell
