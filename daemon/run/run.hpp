// One run: the estimation from its start to its end, and what all its dwells have in common. Dwell indices and t = 0
// are the run's.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/estimate/estimation_thread.hpp"
#include "daemon/estimate/estimator.hpp"
#include "daemon/estimate/long_work.hpp"
#include "daemon/report/dwell_view.hpp"
#include "daemon/watchdog.hpp"

namespace dwell {

// Bound to one thread, in dwelld the event loop's.
class Run {
 public:
  // devices, edges (null: none) and log must outlive this. wake: called on the estimation thread when there is a new
  // snapshot or event; must not block.
  Run(const config::RigFile& file, std::vector<DeviceFeed> devices, gpio::Link* edges, Log& log,
      std::function<void()> wake);

  void start();
  // Ends the run: the current dwell completes. What was published last can still be read. Harmless a second time.
  void end();

  // Moves on to the newest snapshot; false: there was no newer one.
  bool refresh();
  [[nodiscard]] const Snapshot& latest() const noexcept { return estimator_.latest(); }
  // What happened next; false: nothing more so far.
  bool next_event(RunEvent& out) { return estimator_.next_event(out); }
  // The operator's rearm; false: too many at once.
  bool rearm() noexcept { return estimator_.rearm(); }

  [[nodiscard]] const RunInfo& info() const noexcept { return info_; }
  // For the watchdog; none while the run is not going on.
  [[nodiscard]] std::optional<WatchedThread> thread() const;

 private:
  RunInfo info_;
  const std::shared_ptr<LongWork> long_work_;  // shared by the two threads
  Estimator estimator_;
  std::optional<EstimationThread> thread_;
  std::optional<LongWorkThread> long_thread_;
};

}  // namespace dwell
