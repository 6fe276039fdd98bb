#include "core/motion/pattern_in_noise.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/wording.hpp"

namespace dwell {

double pattern_in_noise(const Pass& pass, std::size_t c, double u_noise, const Whiteness& innovations) {
  const double part = std::clamp(pass.unforeseen[c], 0.0, 1.0);
  const double by_motion = part + 2 * std::sqrt(part * (1 - part)),
               by_chance = sigmas::kSure / std::sqrt(pass.count[c]);
  const bool is_pattern = innovations.p < kContradicted && innovations.largest > by_motion + by_chance;
  return is_pattern ? std::sqrt(innovations.largest) * u_noise : 0.0;
}

double error_of_rounding(const MotionData& data, int channel) {
  double least = INFINITY, before = kNaN;
  for (const MotionReading& reading : data.readings) {
    if (reading.channel != channel) continue;
    if (const double apart = std::abs(reading.value - before); apart > 0) least = std::min(least, apart);
    before = reading.value;
  }
  return std::isfinite(least) ? 0.5 * least : 0.0;
}

std::string words_of_pattern(const ReadingsPattern& pattern) {
  return "the readings of " + pattern.channel + " err in a pattern, by " + percent(pattern.at_least) +
         " of its motion or more. It is no noise, and the other channels show that the table does not move so. Hum "
         "does this, a register that is refreshed at another rate than it is read, wrong instants, or a transducer "
         "that distorts";
}

}  // namespace dwell
