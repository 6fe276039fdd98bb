// Refines the drive's frequency from all channels, and sums the blocks at it.
#pragma once

#include "core/blocks.hpp"
#include "core/rig.hpp"

namespace dwell {

struct BlockRange {
  int from = 0, to = 0;    // blocks [from, to)
  bool with_open = false;  // and the block that is still open
};

// Gauss-Newton on ω over the range, all channels of motion and force weighted by their own residuals; within the rig's
// search range; not at all for a fixed reference. omega (rad/s): start and result. Leaves `totals` at it, about the
// centroid of `reference_channel`'s samples, where phase and frequency are uncorrelated (an empty range: about
// fallback_ns). Returns the standard uncertainty of ω in rad/s: from the residuals, or as stated for a fixed one.
// O(blocks · channels · H) a step, seven steps at most, no allocation. Thread-safe if `totals` is the caller's own.
double refine_and_sum(const Rig& rig, const Blocks& blocks, const BlockRange& range, int reference_channel,
                      std::int64_t fallback_ns, double& omega, Totals& totals) noexcept;

// ω within the range that the rig file allows to be searched.
[[nodiscard]] double within_search(const Rig& rig, double omega) noexcept;

}  // namespace dwell
