// The channels whose readings are faulty as they come. The method of any motion uses them unchanged.
#pragma once

#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/result/condition.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Three kinds of channels, ascending, without auxiliary ones. The dwell withholds a channel, because its readings are
// clipped, stuck, foreign or out of range. It leaves out more than one in a thousand of the channel's readings. The
// register is held, and its new values get other instants. pipeline: as it stands with this dwell; its channel() and
// condition_reason() are asked, nothing else. Allocates only if there are any; the pipeline's thread.
[[nodiscard]] std::vector<ChannelFault> readings_at_fault(const Rig& rig, const Pipeline& pipeline, const Dwell& dwell);

}  // namespace dwell
