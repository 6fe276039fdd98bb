#include "daemon/report/dwell_view.hpp"

namespace dwell {

const char* deformation_unit(Motion motion) noexcept { return motion == Motion::rotation ? "rad" : "m"; }
const char* stiffness_unit(Motion motion) noexcept { return motion == Motion::rotation ? "N*m/rad" : "N/m"; }
const char* damping_unit(Motion motion) noexcept { return motion == Motion::rotation ? "N*m*s/rad" : "N*s/m"; }

std::string si_unit(const Channel& channel, Motion motion) {
  const bool rotation = motion == Motion::rotation;
  switch (channel.measures) {
    case Quantity::displacement:
      return rotation ? "rad" : "m";
    case Quantity::velocity:
      return rotation ? "rad/s" : "m/s";
    case Quantity::acceleration:
      return rotation ? "rad/s2" : "m/s2";
    case Quantity::force:
      return rotation ? "N*m" : "N";
    case Quantity::auxiliary:
      break;
  }
  return channel.unit;
}

std::vector<ChannelLabel> channel_labels(const Rig& rig) {
  std::vector<ChannelLabel> labels;
  labels.reserve(rig.channels.size());
  for (const Channel& channel : rig.channels) labels.push_back({channel.name, si_unit(channel, rig.motion)});
  return labels;
}

DwellView make_view(const Dwell& dwell, const Rig& rig, const RunInfo& run) {
  return {rig.motion, channel_labels(rig), run, dwell};
}

}  // namespace dwell
