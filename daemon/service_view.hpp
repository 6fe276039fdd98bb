// The service as it stands at one instant: what every answer and every outlet is made from.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "config/rig_file.hpp"
#include "core/rig/rig.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/health.hpp"
#include "daemon/log/log.hpp"
#include "daemon/record/recorder.hpp"
#include "daemon/report/dwell_view.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/serve/modbus_server.hpp"
#include "daemon/traces/traces.hpp"
#include "daemon/watchdog.hpp"

namespace dwell {

class AlarmList;

// What those who ask the service have got from it.
struct Clients {
  HttpStats http{};
  std::uint64_t wrong_tokens = 0;
  std::optional<ModbusStats> modbus{};  // none: PLCs are not served
};

struct Recording {
  std::optional<record::RecorderState> state{};         // none: the service does not record
  std::shared_ptr<const record::ListedRuns> runs{};     // null: as an empty list
  std::shared_ptr<const record::RunVerdicts> audits{};  // of the runs; null: none is audited yet
};

// The references live as long as the call that is given it.
struct ServiceView {
  const Rig& rig;
  const RunInfo& run;
  const Snapshot& snapshot;
  Health health{};                 // judged of all the rest
  std::int64_t now_ns = 0;         // CLOCK_MONOTONIC_RAW
  std::int64_t now_utc_ns = 0;     // 0: not known
  bool clock_synchronized = true;  // the computer's clock is
  double uptime_s = 0.0;
  Clients clients{};
  LogStats log{};
  std::vector<WatchedThread> threads{};
  gpio::Status gpio{};  // of the lines that are configured
  Recording recording{};
  const NewestLines* events = nullptr;          // null: none are kept
  const AlarmList* alarms = nullptr;            // null: as an empty list
  const Traces* traces = nullptr;               // null: none are kept
  config::VerificationSettings verification{};  // what is asked of the model, as the rig file has it
};

// The current dwell with what stands beside it: its coefficients by any motion, what is known of its model, its
// age. Its limits have a verdict only while it is measured. Where it is stale, a doubt that names every element says
// why: then neither limits nor model have a verdict.
[[nodiscard]] DwellView live_dwell(const ServiceView& now);

// A dwell that has ended, with the verdicts on its limits and, once it has been verified, on its model.
[[nodiscard]] DwellView finished_dwell(const ServiceView& now, const Dwell& dwell);

}  // namespace dwell
