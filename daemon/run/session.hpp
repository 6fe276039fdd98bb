// Everything made from one rig file: the devices' plugin instances, their rings, the GPIO lines, the recorder, and
// the run. The server, the log and the watchdog outlive it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/log/log.hpp"
#include "daemon/outlets/outlet.hpp"
#include "daemon/run/operator_requests.hpp"
#include "daemon/run/run.hpp"
#include "daemon/traces/traces.hpp"
#include "daemon/watchdog.hpp"

namespace dwell {

// Bound to one thread, in dwelld the event loop's.
class Session {
 public:
  // Makes the devices (none is touched yet); fails with the reason. `drivers` yields the plugins' tables, which stay
  // valid for ever. wake: called on the estimation thread when the run has something new; must not block.
  static tl::expected<std::unique_ptr<Session>, std::string> make(config::RigFile file,
                                                                  const config::SchemaSource& drivers, Log& log,
                                                                  std::function<void()> wake);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Starts the run, then the devices. A rig that is off is no failure.
  tl::expected<void, std::string> start();
  // Stops the devices, all at once, then ends the run; within about half a second. A driver that does not stop within
  // 1 s is left behind, cut off from everything: what it hangs in cannot be ended, and must not cost the end of the
  // run. The destructor does it where nobody has; what the run published last can be read until then.
  void end();

  [[nodiscard]] const config::RigFile& file() const noexcept;
  [[nodiscard]] Run& run() noexcept;
  [[nodiscard]] OperatorRequests& operators() noexcept;

  // Takes the waiting records into the traces and returns these. To be called at least once a second: the queue holds
  // 2 s of a large rig (TraceFeed::kRecords).
  [[nodiscard]] const Traces& traces();

  // How the rig's GPIO lines stand; none is configured where there is no [gpio].
  [[nodiscard]] gpio::Status gpio() const;
  // The rig's lamps; null: it has none.
  [[nodiscard]] Outlet* lamps() noexcept;
  // Records the runs; null: nothing is recorded.
  [[nodiscard]] record::Recorder* recorder() noexcept;

  // What the watchdog looks at.
  [[nodiscard]] std::vector<WatchedThread> threads() const;
  [[nodiscard]] std::vector<WatchedRing> rings() const;

 private:
  struct Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell
