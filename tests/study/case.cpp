#include "tests/study/case.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace dwell::study {

double Case::threshold(int c) const {
  return std::max(rig.tolerance * std::abs(motion->phasor(c, 1)),
                  3 * lines[static_cast<std::size_t>(c)].noise() * std::sqrt(2 / (10 * samples_per_period(c))));
}

const char* name_of(Population population) {
  switch (population) {
    case Population::white:
      return "white";
    case Population::tracked:
      return "tracked";
    case Population::hum:
      return "hum";
    case Population::type_b:
      return "type_b";
    case Population::quantized:
      return "quantized";
    case Population::coarse:
      return "coarse";
    case Population::stiff:
      return "stiff";
    case Population::amplitude_step:
      return "amplitude_step";
    case Population::frequency_step:
      return "frequency_step";
    case Population::small_step:
      return "small_step";
    case Population::stop:
      return "stop";
    case Population::steady:
      return "steady";
    case Population::ramps:
      return "ramps";
    case Population::resonance:
      return "resonance";
    case Population::knocks:
      return "knocks";
    case Population::disturbed:
      return "disturbed";
  }
  return "";
}

std::string Case::description() const {
  double most = 0.0, fewest = INFINITY, noise = 0.0, hum = 0.0;
  for (int c = 0; c < channels(); ++c) {
    most = std::max(most, samples_per_period(c));
    fewest = std::min(fewest, samples_per_period(c));
    hum = std::max(hum, lines[static_cast<std::size_t>(c)].hum / std::abs(motion->phasor(c, 1)));
    noise = std::max(noise, lines[static_cast<std::size_t>(c)].noise() / std::abs(motion->phasor(c, 1)));
  }
  char text[256];
  std::snprintf(text, sizeof text,
                "n=%d %s f=%.2f Hz (%s) H=%d tau=%.1f periods, %.0f…%.0f samples a period, noise up to %.2g, tolerance "
                "%.3g, ",
                chain.mass_count(), chain.boundary == Boundary::clamped ? "clamped" : "free", frequency_hz,
                rig.excitation.reference == Reference::fixed ? "fixed" : "tracked", rig.excitation.harmonics,
                motion->time_constant_s() * frequency_hz, fewest, most, noise, rig.tolerance);
  std::string more;
  if (hum > 0) more += ", hum up to " + std::to_string(hum);
  if (glitches > 0) more += ", glitches";
  if (lost > 0) more += ", lost packets";
  for (const Disturbance& disturbance : disturbances) more += "; " + disturbance.told;
  return text + remark + more;
}

}  // namespace dwell::study
