// Chooses the runs to delete: those that ended too long ago, then the oldest ones while all together are too large.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/run_list.hpp"

namespace dwell::record {

// The limits of the rig file; without a limit nothing is deleted.
struct RetentionPolicy {
  std::optional<double> days;       // after a run's end
  std::optional<double> gigabytes;  // 10^9 bytes, of all runs together
};

struct Deletion {
  ListedRun run;
  std::string why;  // "older than 400 days"
};

// Never chooses a run that goes on, is protected, or cannot be read. These count in the size all the same. Pure.
[[nodiscard]] std::vector<Deletion> choose_deletions(const ListedRuns& runs, const RetentionPolicy& policy,
                                                     std::int64_t now_utc_ns);

}  // namespace dwell::record
