// Tells systemd how the service stands (sd_notify). Where nobody asked for it (no NOTIFY_SOCKET) every call does
// nothing.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace dwell {

class Notifier {
 public:
  // Reads WATCHDOG_USEC and WATCHDOG_PID once.
  Notifier();

  void ready() const;
  void stopping() const;
  void feed_watchdog() const;
  // One line for people, shown by systemctl status; sent when it changes.
  void status(std::string_view text);

  // Within so many ms the watchdog wants to be fed; 0: it is not there.
  [[nodiscard]] std::int64_t watchdog_ms() const noexcept { return watchdog_ms_; }

 private:
  std::int64_t watchdog_ms_ = 0;
  std::string status_;
};

}  // namespace dwell
