#include "core/dwell/readings_at_fault.hpp"

#include <algorithm>

namespace dwell {

std::vector<ChannelFault> readings_at_fault(const Rig& rig, const Pipeline& pipeline, const Dwell& dwell) {
  std::vector<ChannelFault> faults;
  for (std::size_t i = 0; i < std::min(rig.channels.size(), dwell.phasors.size()); ++i) {
    const auto c = static_cast<int>(i);
    const Condition condition = pipeline.channel(c).condition;
    const bool mended = condition == Condition::held || condition == Condition::gated;
    const bool withheld =
        !dwell.phasors[i].valid &&
        (condition == Condition::clipped || condition == Condition::stuck || condition == Condition::overrange);
    if (!(mended || withheld) || rig.channels[i].measures == Quantity::auxiliary) continue;
    const std::string why = pipeline.condition_reason(c);
    faults.push_back({c, rig.channels[i].name + ": " + (why.empty() ? to_string(condition) : why)});
  }
  return faults;
}

}  // namespace dwell
