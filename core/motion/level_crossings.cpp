#include "core/motion/level_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/intake/rounding_step.hpp"

namespace dwell {
namespace {

constexpr double kSmooths = 0.3;  // steps: noise that smooths the rounding, see the header

struct RoundedLine {
  RoundingStep rounding;
  bool coarse = false;
  bool heard = false;
  MotionReading before;
};

}  // namespace

std::vector<int> take_level_crossings(const Rig& rig, const std::vector<double>& noise, MotionData& data) {
  std::vector<RoundedLine> lines(rig.channels.size());
  for (const MotionReading& reading : data.readings) {
    RoundedLine& line = lines[static_cast<std::size_t>(reading.channel)];
    if (line.heard) line.rounding.add(reading.value - line.before.value);
    line.heard = true;
    line.before = reading;
  }
  std::vector<int> changed;
  for (std::size_t c = 0; c < lines.size(); ++c) {
    const double step = lines[c].rounding.step();
    // Seen from reading to reading: the noise and, of a motion of several steps, the rounding.
    lines[c].coarse = step > 0 && std::isfinite(step) && noise[c] < step * std::sqrt(1.0 / 12 + kSmooths * kSmooths);
    lines[c].heard = false;
    if (lines[c].coarse) changed.push_back(static_cast<int>(c));
  }
  if (changed.empty()) return changed;

  std::vector<MotionReading> out;
  out.reserve(data.readings.size());
  for (const MotionReading& reading : data.readings) {
    RoundedLine& line = lines[static_cast<std::size_t>(reading.channel)];
    if (!line.coarse) {
      out.push_back(reading);
      continue;
    }
    const double steps = std::abs(reading.value - line.before.value) / line.rounding.step();
    if (line.heard && steps > 1.5) out.push_back(reading);
    if (line.heard && steps > 0.5 && steps <= 1.5)
      out.push_back({line.before.t_ns + (reading.t_ns - line.before.t_ns) / 2, reading.channel,
                     0.5 * (line.before.value + reading.value)});
    line.heard = true;
    line.before = reading;
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  data.readings = std::move(out);
  return changed;
}

}  // namespace dwell
