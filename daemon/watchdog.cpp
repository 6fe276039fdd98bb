#include "daemon/watchdog.hpp"

#include <cstdio>

namespace dwell {

std::string Watchdog::judge(std::int64_t now_ns, const std::vector<WatchedThread>& threads,
                            const std::vector<WatchedRing>& rings) {
  std::string trouble;
  const auto add = [&trouble](const std::string& what, std::int64_t for_ns) {
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, " for %.1f s", static_cast<double>(for_ns) * 1e-9);
    if (!trouble.empty()) trouble += "; ";
    trouble += what + seconds;
  };
  for (const WatchedThread& thread : threads) {
    if (thread.ours && !thread.turns(now_ns)) add("thread " + thread.name + " has not turned", thread.still_ns(now_ns));
  }
  for (const WatchedRing& ring : rings) {
    const auto [found, fresh] = rings_.try_emplace(ring.name, Progress{ring.left, now_ns});
    Progress& progress = found->second;
    if (ring.left != progress.left || ring.entered <= ring.left) progress = {ring.left, now_ns};
    const std::int64_t still_ns = now_ns - progress.since_ns;
    if (still_ns > kRingBound_ns)
      add(std::to_string(ring.entered - ring.left) + " samples of " + ring.name + " are not taken", still_ns);
  }
  return trouble;
}

}  // namespace dwell
