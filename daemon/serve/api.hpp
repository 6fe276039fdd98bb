// What the service says over HTTP and over the control socket, made from the newest snapshot. Pure: no I/O, no clock.
// A number that does not exist is null. Bound to one thread; throws only where memory ends.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/rig/rig.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/health.hpp"
#include "daemon/log/log.hpp"
#include "daemon/report/dwell_view.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/watchdog.hpp"

namespace dwell {

// Everything the answers are made from, as it stands at now_ns. The references live as long as the call.
struct ServiceView {
  const Rig& rig;
  const std::vector<std::string>& drivers;  // by device
  const RunInfo& run;
  const Snapshot& snapshot;
  std::int64_t now_ns = 0;  // CLOCK_MONOTONIC_RAW
  double uptime_s = 0.0;
  HttpStats http;
  LogStats log;
  std::vector<WatchedThread> threads;
  std::string trouble;  // the watchdog's; empty: all is well
  gpio::Status gpio{};  // of the lines that are configured
};

// Finished dwells in one answer of /api/v1/dwells at most, and unless ?count= asks for fewer …
inline constexpr std::size_t kDwellsPerAnswer = 100;
// … and at most so many bytes of them, but always one. Larger: 128 clients that ask at once and read slowly hold more
// memory; smaller: more requests for many large dwells (of 30 elements one has 0.4 to 0.6 MB).
inline constexpr std::size_t kBytesOfDwells = 4'000'000;

// GET `path`.
[[nodiscard]] HttpReply http_answer(const ServiceView& view, std::string_view path, std::string_view query);

// One line of the control socket. rearm: the operator's action; false: too many at once.
[[nodiscard]] std::string control_answer(const ServiceView& view, std::string_view line,
                                         const std::function<bool()>& rearm);

// The dwell object of the snapshot, one line.
[[nodiscard]] std::string dwell_text_json(const ServiceView& view);

}  // namespace dwell
