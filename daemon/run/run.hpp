// The estimation of a session from its start to its end, with its threads. Where the rig file has a [recording], runs
// begin and end within it; else it is one run.
#pragma once

#include <cstdint>
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
  // devices, edges (null: none), log and sink must outlive this. wake: called on the estimation thread when there is a
  // new snapshot or event; must not block. sink: gets the stream and the results; may be null.
  // traces: gets the stream, for displays; may be null; must outlive this.
  Run(const config::RigFile& file, std::vector<DeviceFeed> devices, gpio::Link* edges, Log& log,
      std::function<void()> wake, record::StreamSink* sink = nullptr, TraceFeed* traces = nullptr);

  void start();
  // Ends the run: the current dwell completes. What was published last can still be read. Harmless a second time.
  void end();

  // Moves on to the newest snapshot; false: there was no newer one.
  bool refresh();
  [[nodiscard]] const Snapshot& latest() const noexcept { return estimator_.latest(); }
  // What happened next; false: nothing more so far.
  bool next_event(RunEvent& out) { return estimator_.next_event(out); }
  // An operator's requests, with their numbers (0: none); false: too many at once.
  bool begin_run(std::uint16_t request) noexcept { return estimator_.begin_run(request); }
  bool end_run(std::uint16_t request) noexcept { return estimator_.end_run(request); }
  bool rearm(std::uint16_t request = 0) noexcept { return estimator_.rearm(request); }
  // The recorder's request for a new run in place of the current one; false: too many at once.
  bool restart() noexcept { return estimator_.begin_run(0); }
  [[nodiscard]] bool has_room() const noexcept { return estimator_.has_room(); }
  // Whether runs begin and end within the session, and are recorded.
  [[nodiscard]] bool bracketed() const noexcept { return bracketed_; }

  [[nodiscard]] const RunInfo& info() const noexcept { return info_; }
  // For the watchdog; none while the run is not going on.
  [[nodiscard]] std::optional<WatchedThread> thread() const;

 private:
  const bool bracketed_;
  RunInfo info_;
  std::int64_t start_utc_ns_ = 0;              // as in info_
  const std::shared_ptr<LongWork> long_work_;  // shared by the three threads; null: the rig file asks for none
  Estimator estimator_;
  std::optional<EstimationThread> thread_;
  std::optional<LongWorkThread> motion_thread_, verify_thread_;
};

}  // namespace dwell
