#include "core/stream/assembler.hpp"

namespace dwell {

std::vector<Assembler::Source> Assembler::sources(const Rig& rig) {
  std::vector<Source> sources;
  for (const Device& device : rig.devices) sources.push_back({device.clock, {}, device.rate_hz, false});
  for (std::size_t i = 0; i < rig.channels.size(); ++i)
    if (const int device = rig.channels[i].device; device >= 0)
      sources[static_cast<std::size_t>(device)].channels.push_back(static_cast<std::uint16_t>(i));
  return sources;
}

Assembler::Assembler(const std::vector<Source>& devices, std::int64_t hold_back_ns, std::size_t capacity)
    : merger_(devices.size() + 2, hold_back_ns, capacity) {
  clocks_.reserve(devices.size());
  for (std::size_t i = 0; i < devices.size(); ++i) {
    clocks_.emplace_back(devices[i].clock, devices[i].channels, devices[i].rate_hz);
    if (devices[i].leads) merger_.set_leading(i);
  }
}

}  // namespace dwell
