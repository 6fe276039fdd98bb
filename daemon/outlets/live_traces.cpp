#include "daemon/outlets/live_traces.hpp"

#include <utility>

#include "daemon/serve/traces_json.hpp"

namespace dwell {

void LiveTraces::push(HttpServer& server, const Traces& traces, std::size_t channels) {
  const std::int64_t first = std::exchange(told_, traces.complete());
  if (first == told_ || !server.asked_for(kEvent)) return;
  server.broadcast_to_askers(kEvent, traces_event(traces, first, channels));
}

}  // namespace dwell
