// The channels whose readings are faulty as they come. The method of any motion uses them unchanged.
#pragma once

#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/result/condition.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Channels that the dwell withholds because their readings are clipped, stuck or out of range, and those of which it
// uses what the intake has made of the readings: held ones, whose new values get other instants, and ones of whose
// readings more than one in a thousand is left out. Ascending, without auxiliary channels. pipeline: as it stands with
// this dwell; its channel() and condition_reason() are asked, nothing else. Allocates only if there are any; the
// pipeline's thread.
[[nodiscard]] std::vector<ChannelFault> readings_at_fault(const Rig& rig, const Pipeline& pipeline, const Dwell& dwell);

}  // namespace dwell
