// The events of a replay against those that a file holds: of a child file all, of a run its changes of state.
#pragma once

#include <cstdint>
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

// The same for the changes of state of a run, each with its position and its text, between `begins`, the position of
// RunEdge::begins, and the end of the run. Before it another pipeline's state may have been shown. Of a run that was
// cut off up to the last change that is stored, since the one after it may be lost. The instants are those of the
// computer's clock then, and a replay has none.
[[nodiscard]] record::Result<void> compare_states(std::vector<record::StoredEvent> replayed, std::uint64_t begins,
                                                  record::RunReader& run, ReplayFindings& to);

}  // namespace dwell::ctl
