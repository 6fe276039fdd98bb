// Finds channels at different places whose readings are the same: both show one transducer.
//
// Two wires on one amplifier, or one register read twice. The element between the places then does not deform and is
// not identified; every other element comes out wrong, and nothing else shows it. An element may be so stiff that its
// ends move alike. But the transducers' readings at rest lie anywhere, and do not agree by chance.
#pragma once

#include <span>
#include <vector>

#include "core/dwell/report.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// A doubt of all elements for each such pair. Compared are the device's own numbers: scale and offset of the rig file
// do not matter. channels: as Rig::channels. Allocates, thread-safe.
[[nodiscard]] std::vector<Doubt> twin_channels(const Rig& rig, std::span<const ChannelResult> channels);

}  // namespace dwell
