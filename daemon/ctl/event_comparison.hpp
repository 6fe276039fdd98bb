// The events of a child file against those of the replay with its rig file.
#pragma once

#include <vector>

#include "daemon/ctl/replay_check.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/run_reader.hpp"

namespace dwell::ctl {

// Adds each difference to `to`, and counts the events. Events at one position are compared in their order, those that
// are the same in both left out first. Fails where the child cannot be read. Memory: that of `replayed`, and of as many
// events of the child, at most.
[[nodiscard]] record::Result<void> compare_events(const std::vector<record::StoredEvent>& replayed,
                                                  record::RunReader& child, ReplayFindings& to);

}  // namespace dwell::ctl
