// The events of a replay against those that a file holds. Child file: all events; run: changes of state only.
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

// Compares the changes of state of a run: position and text. Compared are those between RunEdge::begins, at position
// `begins_at`, and the run's last record. Before, another pipeline's state may have been shown. If the run was cut off,
// the last stored change is the last one compared: a later one may be lost. Adds each difference to `to`, and counts
// the events. Keeps all changes of state in memory. Fails where the run cannot be read.
[[nodiscard]] record::Result<void> compare_states(std::vector<record::StoredEvent> replayed, std::uint64_t begins_at,
                                                  record::RunReader& run, ReplayFindings& to);

}  // namespace dwell::ctl
