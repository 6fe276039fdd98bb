#include "daemon/report/dwell_view.hpp"

#include <utility>

namespace dwell {

std::vector<ChannelLabel> channel_labels(const Rig& rig) {
  std::vector<ChannelLabel> labels;
  labels.reserve(rig.channels.size());
  for (const Channel& channel : rig.channels) {
    const bool auxiliary = channel.measures == Quantity::auxiliary;
    labels.push_back({channel.name, auxiliary ? channel.unit : config::si_unit(channel.measures, rig.motion)});
  }
  return labels;
}

DwellView make_view(const Dwell& dwell, const Rig& rig, const RunInfo& run, std::vector<JudgedLimit> limits) {
  return {rig.motion, channel_labels(rig), run, dwell, nullptr, std::nullopt, std::move(limits), std::nullopt};
}

DwellView make_view(const Dwell& dwell, const Rig& rig, const RunInfo& run) {
  return make_view(dwell, rig, run, judge_limits(rig, dwell));
}

}  // namespace dwell
