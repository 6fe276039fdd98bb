// Events for a page that people read. Faults and losses come once a second as long as they last. Those that say the
// same of the same device or channel become one line.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/record/run_entries.hpp"

namespace dwell::record {

struct FoldedEvent {
  StoredEvent event;          // the first; its text has the sum of the counts, or the number of events
  std::uint64_t entries = 1;  // number of events that say the same
  std::string last_utc;       // of the last of them
};

// In the order of the first of each. All but faults and losses stay as they are.
[[nodiscard]] std::vector<FoldedEvent> folded(const std::vector<StoredEvent>& events);

}  // namespace dwell::record
