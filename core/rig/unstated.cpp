#include "core/rig/unstated.hpp"

#include "core/base/wording.hpp"

namespace dwell {
namespace {

bool delay_stated(const Rig& rig, const Channel& channel) {
  if (channel.stated.delay_u || channel.delay_u_s > 0) return true;
  if (channel.device < 0) return false;
  const Device& device = rig.devices[static_cast<std::size_t>(channel.device)];
  return device.delay_u_stated || device.delay_u_s > 0;
}

bool corner_stated(const Filter& filter) {
  return filter.kind == FilterKind::none || filter.hz_u_stated || filter.hz_u > 0;
}

}  // namespace

std::vector<std::string> unstated_uncertainties(const Rig& rig) {
  std::vector<std::string> out;
  if (rig.mass_u.empty() && !rig.masses.empty()) {
    const std::size_t n = rig.masses.size();
    out.push_back(n == 1 ? "mass 1" : n == 2 ? "masses 1 and 2" : "masses 1 … " + std::to_string(n));
  }
  const auto add = [&](const std::string& one, const auto& is_stated) {
    std::vector<std::string> names;
    std::size_t channels = 0;
    for (const Channel& channel : rig.channels) {
      if (channel.measures == Quantity::auxiliary) continue;
      ++channels;
      if (!is_stated(channel)) names.push_back(channel.name);
    }
    if (names.empty()) return;
    const bool all = names.size() == channels && channels > 1;
    out.push_back(one + (names.size() > 1 ? (one.back() == 's' ? "es of " : "s of ") : " of ") +
                  (all ? "all channels" : listed(names)));
  };
  add("scale", [](const Channel& channel) { return channel.stated.scale_u || channel.scale_u > 0; });
  add("delay", [&](const Channel& channel) { return delay_stated(rig, channel); });
  add("low-pass", [](const Channel& channel) { return corner_stated(channel.lowpass); });
  add("high-pass", [](const Channel& channel) { return corner_stated(channel.highpass); });
  return out;
}

}  // namespace dwell
