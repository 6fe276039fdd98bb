// Everything made from one rig file: the devices' plugin instances, their rings, the estimation and its thread. The
// server, the log and the watchdog outlive it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/health.hpp"
#include "daemon/log/log.hpp"
#include "daemon/watchdog.hpp"

namespace dwell {

class Session {
 public:
  // Makes the devices (none is touched yet); fails with the reason. `drivers` yields the plugins' tables, which stay
  // valid for ever. published: called on the estimation thread after each snapshot; must not block.
  static tl::expected<std::unique_ptr<Session>, std::string> make(config::RigFile file,
                                                                  const config::SchemaSource& drivers, Log& log,
                                                                  std::function<void()> published);
  // Stops the devices, all at once, then ends the run; within about half a second. A driver that does not stop within
  // 1 s is left behind, cut off from everything: what it hangs in cannot be ended, and must not cost the end of the
  // run.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Starts the estimation, then the devices. A rig that is off is no failure.
  tl::expected<void, std::string> start();

  [[nodiscard]] const config::RigFile& file() const noexcept;

  // Of one thread, the event loop's: moves on to the newest snapshot; the operator's rearm (false: too many at once).
  bool refresh() noexcept;
  [[nodiscard]] const Snapshot& latest() const noexcept;
  bool rearm() noexcept;

  // How the rig's GPIO lines stand; none is configured where there is no [gpio].
  [[nodiscard]] gpio::Status gpio() const;
  // Of the event loop: what the lamps are to show; at least once a second.
  void light_lamps(const Health& health);

  // What the watchdog looks at.
  [[nodiscard]] std::vector<WatchedThread> threads() const;
  [[nodiscard]] std::vector<WatchedRing> rings() const;

 private:
  struct Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell
