#include "core/dwell/readings_at_fault.hpp"

#include <algorithm>

namespace dwell {
namespace {

// Part of a channel's readings. If fewer are left out, they cannot make any motion err: repeats by an interval in this
// part of the readings delay a channel by a thousandth of an interval. With a single glitch at fault, as with 0, no
// contradiction of a long recording would be believed.
constexpr double kFew = 1e-3;

}  // namespace

std::vector<ChannelFault> readings_at_fault(const Rig& rig, const Pipeline& pipeline, const Dwell& dwell) {
  std::vector<ChannelFault> faults;
  for (std::size_t i = 0; i < std::min(rig.channels.size(), dwell.phasors.size()); ++i) {
    const auto c = static_cast<int>(i);
    const ChannelNow channel = pipeline.channel(c);
    const Condition condition = channel.condition;
    const bool foreign = condition == Condition::gated || condition == Condition::overrange;
    const auto left_out = static_cast<double>(channel.rejected), all = left_out + static_cast<double>(channel.used);
    const bool mended = condition == Condition::held || (foreign && left_out > kFew * all);
    const bool withheld =
        !dwell.phasors[i].valid && (foreign || condition == Condition::clipped || condition == Condition::stuck);
    if (!(mended || withheld) || rig.channels[i].measures == Quantity::auxiliary) continue;
    const std::string why = pipeline.condition_reason(c);
    faults.push_back({c, rig.channels[i].name + ": " + (why.empty() ? to_string(condition) : why)});
  }
  return faults;
}

}  // namespace dwell
