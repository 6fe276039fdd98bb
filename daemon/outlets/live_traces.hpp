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
  // Between two pushes: 20 a second look continuous. Halved: twice the events for the same bins. Doubled: it jerks.
  static constexpr std::chrono::milliseconds kEvery{50};
  static constexpr const char* kEvent = "traces";

  // Sends the bins completed since the last call to the streams that asked for them: the same bytes to all. Encodes
  // nothing where no stream asked.
  void push(HttpServer& server, const Traces& traces, std::size_t channels);

 private:
  std::int64_t told_ = 0;  // number of the first bin that has not been sent
};

}  // namespace dwell
