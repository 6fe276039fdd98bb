// Pushes the traces to the live streams that ask for them, 20 times a second.
#pragma once

#include <chrono>
#include <cstdint>

#include "daemon/serve/http_server.hpp"
#include "daemon/traces/traces.hpp"

namespace dwell {

// Bound to the event loop's thread.
class LiveTraces {
 public:
  // Between two pushes: 20 a second look continuous. Halved, twice the events for the same bins.
  static constexpr std::chrono::milliseconds kEvery{50};
  static constexpr const char* kEvent = "traces";

  // Tells the streams that asked for it of the bins that are complete since the last call. All are sent the same
  // bytes; nothing is written where nobody asked.
  void push(HttpServer& server, const Traces& traces, std::size_t channels);

 private:
  std::int64_t told_ = 0;  // bins up to this one
};

}  // namespace dwell
