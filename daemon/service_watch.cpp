#include "daemon/service_watch.hpp"

#include <utility>

namespace dwell {

void ServiceWatch::look(std::int64_t now_ns, const std::vector<WatchedThread>& threads,
                        const std::vector<WatchedRing>& rings) {
  const bool worked = std::exchange(trouble_, watchdog_.judge(now_ns, threads, rings)).empty();
  if (worked && !trouble_.empty()) log_.error("the service does not work: " + trouble_);
  if (!worked && trouble_.empty()) log_.info("the service works again");
  look_at_log(now_ns);
}

// Said where there is another place than the file, and in the file once it takes lines again.
void ServiceWatch::look_at_log(std::int64_t now_ns) {
  const LogStats stats = log_.stats();
  const std::string lost = std::to_string(stats.dropped) + " lines lost so far";
  // Each such line tries the file anew.
  if (stats.failing && log_failures_.admit(now_ns))
    log_.error("the log file does not take lines: " + stats.reason + "; " + lost);
  if (!stats.failing && log_failing_) log_.warning("the log file takes lines again; " + lost);
  log_failing_ = stats.failing;
}

}  // namespace dwell
