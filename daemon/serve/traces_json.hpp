// The traces as GET /api/v1/traces and the live stream tell them. A number is the shortest text that gives the same
// float. It is written straight into the answer, since a JSON document would take ten times as long. Bound to one
// thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/serve/http_server.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

// Bins of a channel in one answer, unless ?points= asks for others …
inline constexpr std::int64_t kTracePoints = 1000;
// … and at most: of one channel, and of all channels together. The latter is an answer of 1.3 MB, written in 10 ms.
inline constexpr std::int64_t kMostTracePoints = 4000, kMostTracePointsInAll = 64'000;
// The longest stretch that is answered less the steady part, since each of its readings is computed anew. 8 channels at
// 1 kHz take 10 ms of the event loop.
inline constexpr double kLongestLess_s = 60.0;

// The query: traces_query.hpp. 503 before the first record, 409 where no dwell has a steady part.
[[nodiscard]] HttpReply traces_answer(const ServiceView& view, std::string_view query);

// The data of the event `traces`: the bins of 20 ms from number `first` on that are complete and kept. One line.
[[nodiscard]] std::string traces_event(const Traces& traces, std::int64_t first, std::size_t channels);

}  // namespace dwell
