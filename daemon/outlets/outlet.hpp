// Whatever shows the service to the outside without being asked implements this, in a file of its own: lamps, the log,
// live streams, systemd's status line. All are called on the event loop's thread.
#pragma once

#include <functional>
#include <initializer_list>
#include <memory>

#include "core/rig/rig.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

class Notifier;

class Outlet {
 public:
  virtual ~Outlet() = default;
  // How the service stands, at every new snapshot and at least once a second. Snapshots in between may be skipped.
  virtual void show(const ServiceView& now) = 0;
  // What has happened in the run: every event, in order, and before the snapshot that has seen it.
  virtual void tell(const RunEvent& event, const Rig& rig) = 0;
};

// Calls each of them; null: there is none. One that throws keeps none of the others from their turn; the first failure
// is thrown on after all.
void call_each(std::initializer_list<Outlet*> outlets, const std::function<void(Outlet&)>& call);

// What each is given must outlive it.

// The run in the log: a line for each change of state and each finished dwell.
[[nodiscard]] std::unique_ptr<Outlet> make_log_lines(Log& log);
// The rig's lamps, `ready` and `fault`.
[[nodiscard]] std::unique_ptr<Outlet> make_lamps(gpio::Link& lines);
// The line that `systemctl status` shows: "measuring, dwell 3, 4 Hz", and the reasons where all is not well.
[[nodiscard]] std::unique_ptr<Outlet> make_systemd_status(Notifier& notifier);

}  // namespace dwell
