// Chooses the runs to delete: those that ended too long ago, then the oldest ones while all together are too large.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/run_list.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {

// The limits of the rig file; without a limit nothing is deleted.
struct RetentionPolicy {
  std::optional<double> days;       // after a run's end
  std::optional<double> gigabytes;  // 10^9 bytes, of all runs together
};

struct Deletion {
  ListedRun run;
  std::string why;      // "older than 400 days"
  bool by_age = false;  // else by size
};

// Says whether an age in days can be believed now. A deletion cannot be undone, so nothing is deleted by age while the
// kernel does not hold the clock for synchronized, nor for a day after the clock was set: whoever set it wrongly has so
// long to see it. Bound to one thread; virtual time.
class AgeDoubt {
 public:
  // A smaller step does not matter to ages, which are days.
  static constexpr std::int64_t kStep_ns = 60'000'000'000;
  // Halved, a clock that was set wrongly over night deletes runs before anybody sees it. Doubled, old runs stay longer.
  static constexpr std::int64_t kAfterStep_ns = 86'400'000'000'000;

  // Call at each turn. Returns why no age can be believed; empty: it can.
  [[nodiscard]] std::string at(const ClockPair& now, bool synchronized);

 private:
  std::optional<ClockPair> before_;
  std::optional<std::int64_t> set_ns_;  // when the clock was set last, ns of the raw clock
};

// Never chooses a run that goes on, is protected, or cannot be read. These count in the size all the same. A run that
// was recorded while the clock was not synchronized has no age. Pure.
[[nodiscard]] std::vector<Deletion> choose_deletions(const ListedRuns& runs, const RetentionPolicy& policy,
                                                     std::int64_t now_utc_ns);

}  // namespace dwell::record
