// Whether all is well, and why not: decided here alone, for the lamps, /api/v1/health, the line that systemd shows and
// the alarms.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/rig/rig.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/log/log.hpp"
#include "daemon/record/recorder.hpp"

namespace dwell {

// What a trouble concerns.
enum class TroubleKind : std::uint8_t {
  service,
  channel,
  device,
  gpio,
  dwell,
  limit,
  log,
  recording,
  clock,
  calibration,  // of a channel
};
[[nodiscard]] const char* to_string(TroubleKind kind) noexcept;  // "service", "channel", …

// One thing that is wrong.
struct Trouble {
  // Names the thing and stays the same while the text changes: "channel:y1", "device:amplifier", "limit:stiffness:2", …
  std::string name;
  std::string text;      // one line for people
  bool degrades = true;  // false: an alarm tells operators of it, and the status stays ok
  TroubleKind kind = TroubleKind::service;
  std::string channel = {};  // its name; empty: it concerns none, or several
  std::string why = {};      // of a channel: `text` without the name, to tell channels together that fail alike
};

// Name of the trouble that the watchdog found: the service itself does not work.
inline constexpr const char* kServiceTrouble = "service";

struct Health {
  // degraded: a channel does not deliver or delivers nothing usable, the dwell that is measured does not use a channel,
  // a channel that a settling dwell needs is gated, a GPIO line does not work, the dwell's data do not suffice, a limit
  // of the rig file is violated, the log loses lines, runs are not recorded as they should. fault: the service itself
  // does not work. An element that the drive does not resolve (its deformation is too small, for instance) degrades
  // nothing: the rig works, and the dwell says why the element has no number.
  enum class Status : std::uint8_t { ok, degraded, fault };
  Status status = Status::ok;
  std::vector<Trouble> troubles;  // with ok, none that degrades
  // A dwell is being measured, all its coefficients may be relied on, none is stale, and the interlock is not open.
  bool ready = false;
  std::string run{};  // whether a run goes on and is recorded: a fact, no fault
  // Limits without a verdict while a dwell goes on: the number is withheld, doubted, stale or not there yet. It is not
  // known whether they are violated. The text is that of an alarm that is active.
  std::vector<Trouble> unknown{};
};
[[nodiscard]] const char* to_string(Health::Status status) noexcept;  // "ok", "degraded", "fault"

// Time since the estimation published the snapshot, s; infinite: it has published nothing. now_ns: CLOCK_MONOTONIC_RAW.
[[nodiscard]] double estimate_age_s(const Snapshot& snapshot, std::int64_t now_ns) noexcept;
// Whether the estimate is older than kOldAfter_s. `update` of a rig file is 1 s at most, so two estimates are missing.
[[nodiscard]] bool is_overdue(const Snapshot& snapshot, std::int64_t now_ns) noexcept;

// trouble: what the watchdog found; empty: nothing. recorder: why runs are not recorded as they should be.
// clock_synchronized: the computer's clock is. utc_ns: its time, ns since 1970, UTC; 0: not known. Pure.
[[nodiscard]] Health judge_health(const Rig& rig, const Snapshot& snapshot, std::int64_t now_ns,
                                  const gpio::Status& lines, const LogStats& log, const std::string& trouble,
                                  const std::vector<record::RecorderAlarm>& recorder = {},
                                  bool clock_synchronized = true, std::int64_t utc_ns = 0);

// Why the status is not ok, in one line: the first few troubles, the others counted; empty with ok.
[[nodiscard]] std::string reason_of(const Health& health);

}  // namespace dwell
