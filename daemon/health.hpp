// Whether all is well, and why not: decided here alone, for the lamps, /api/v1/health and the line that systemd shows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/rig/rig.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/log/log.hpp"

namespace dwell {

struct Health {
  // degraded: a channel does not deliver or delivers nothing usable, a GPIO line does not work, the dwell's data do not
  // suffice, the log loses lines, runs are not recorded as they should. fault: the service itself does not work.
  enum class Status : std::uint8_t { ok, degraded, fault };
  Status status = Status::ok;
  std::vector<std::string> reasons;  // empty with ok
  bool ready = false;  // a dwell is measured whose coefficients may be relied on; the interlock is not open
  std::string run{};   // whether a run goes on and is recorded: a fact, no fault
};
[[nodiscard]] const char* to_string(Health::Status status) noexcept;  // "ok", "degraded", "fault"

// trouble: what the watchdog found; empty: nothing. alarms: why runs are not recorded as they should. Pure.
[[nodiscard]] Health judge_health(const Rig& rig, const Snapshot& snapshot, const gpio::Status& lines,
                                  const LogStats& log, const std::string& trouble,
                                  const std::vector<std::string>& alarms = {});

// The reasons in one line, the first few of many; empty with ok.
[[nodiscard]] std::string reason_of(const Health& health);

}  // namespace dwell
