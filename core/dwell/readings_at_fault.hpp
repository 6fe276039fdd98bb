// The channels whose readings are so faulty that a dwell withholds them.
#pragma once

#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/result/condition.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Channels that the dwell withholds because their readings are clipped, stuck, foreign or out of range, ascending. Held
// channels are not among them, since the method of any motion models them; nor are auxiliary ones. pipeline: as it
// stands with this dwell; its channel() and condition_reason() are asked, nothing else. Allocates only if there are
// any; the pipeline's thread.
[[nodiscard]] std::vector<ChannelFault> readings_at_fault(const Rig& rig, const Pipeline& pipeline, const Dwell& dwell);

}  // namespace dwell
