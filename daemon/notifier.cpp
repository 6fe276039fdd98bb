#include "daemon/notifier.hpp"

#include <systemd/sd-daemon.h>

#include <algorithm>

namespace dwell {

Notifier::Notifier() {
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(0, &period_us) > 0)
    watchdog_ms_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(period_us / 1000));
}

void Notifier::ready() const { sd_notify(0, "READY=1"); }
void Notifier::stopping() const { sd_notify(0, "STOPPING=1\nSTATUS=stopping"); }
void Notifier::feed_watchdog() const { sd_notify(0, "WATCHDOG=1"); }

void Notifier::status(std::string_view text) {
  if (text == status_) return;
  status_ = text;
  std::string line = "STATUS=" + status_;
  std::replace(line.begin(), line.end(), '\n', ' ');
  sd_notify(0, line.c_str());
}

}  // namespace dwell
