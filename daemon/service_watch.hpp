// Whether the service itself works, looked at regularly; the log is told when that changes, and when its own file takes
// no more lines.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/log/log.hpp"
#include "daemon/log/throttle.hpp"
#include "daemon/watchdog.hpp"

namespace dwell {

// Bound to one thread.
class ServiceWatch {
 public:
  // The log must outlive this.
  explicit ServiceWatch(Log& log) : log_(log) {}

  // now_ns: CLOCK_MONOTONIC_RAW.
  void look(std::int64_t now_ns, const std::vector<WatchedThread>& threads, const std::vector<WatchedRing>& rings);

  // What does not work, in words; empty: all does.
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }

 private:
  void look_at_log(std::int64_t now_ns);

  Log& log_;
  Watchdog watchdog_;
  std::string trouble_;
  bool log_failing_ = false;
  Throttle log_failures_;
};

}  // namespace dwell
