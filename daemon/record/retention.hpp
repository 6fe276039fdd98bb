// Which runs are to be deleted: those that ended too long ago, then the oldest while all together are too large.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/run_list.hpp"

namespace dwell::record {

// As the rig file asks for; nothing asked for: nothing is deleted.
struct RetentionPolicy {
  std::optional<double> days;       // after a run's end
  std::optional<double> gigabytes;  // 10^9 bytes, of all runs together
};

struct Deletion {
  ListedRun run;
  std::string why;  // "older than 400 days"
};

// Never one that goes on, is protected, or cannot be read: of the last nobody knows what it is. Protected and running
// ones count in the size all the same. Pure.
[[nodiscard]] std::vector<Deletion> choose_deletions(const ListedRuns& runs, const RetentionPolicy& policy,
                                                     std::int64_t now_utc_ns);

}  // namespace dwell::record
