#include "daemon/traces/steady_part.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/rig/transducer.hpp"

namespace dwell {

std::optional<SteadyPart> SteadyPart::of(const Dwell& dwell, const Rig& rig, std::int64_t origin_ns) {
  if (!dwell.index || !std::isfinite(dwell.settled_s) || !std::isfinite(dwell.frequency_hz.value)) return std::nullopt;
  const auto instant = [origin_ns](double t_s) { return origin_ns + std::llround(t_s * 1e9); };
  SteadyPart part;
  part.dwell_ = *dwell.index;
  part.omega_ = 2.0 * std::numbers::pi * dwell.frequency_hz.value;
  part.ref_ns_ = instant(dwell.t_ref_s);
  part.from_ns_ = instant(dwell.start_s);
  part.fitted_from_ns_ = instant(dwell.settled_s);
  // A dwell that goes on holds beyond its newest datum.
  part.to_ns_ = dwell.state == State::complete ? instant(dwell.end_s) : std::numeric_limits<std::int64_t>::max();
  part.waves_.assign(rig.channels.size(), {kNaN, kNaN, kNaN});
  for (std::size_t i = 0; i < part.waves_.size() && i < dwell.phasors.size(); ++i) {
    if (!dwell.phasors[i].valid) continue;
    const Channel& channel = rig.channels[i];
    const auto seen = dwell.phasors[i].Y * response(channel, device_delay_s(rig, channel), dwell.frequency_hz.value);
    part.waves_[i] = {dwell.phasors[i].mean / channel.si_per_unit, std::abs(seen) / channel.si_per_unit,
                      std::arg(seen)};
  }
  return part;
}

double SteadyPart::at(std::size_t channel, std::int64_t t_ns) const noexcept {
  const Wave& wave = waves_[channel];
  const double angle = omega_ * static_cast<double>(t_ns - ref_ns_) * 1e-9 + wave.phase_rad;
  return wave.mean + wave.amplitude * std::sin(angle);
}

}  // namespace dwell
