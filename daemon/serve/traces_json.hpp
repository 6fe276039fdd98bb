// The traces as GET /api/v1/traces answers them, and as a live stream is told of them. Numbers are written by hand, as
// the shortest text that gives the same float: a library's document would cost ten times the time. Bound to one thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/serve/http_server.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

// Bins of a channel in one answer, unless ?points= asks for others …
inline constexpr std::int64_t kTracePoints = 1000;
// … and at most, and of all channels together: an answer of 1.3 MB, written in 10 ms.
inline constexpr std::int64_t kMostTracePoints = 4000, kMostTracePointsInAll = 64'000;
// The longest stretch that may be asked for less the steady part: each of its readings is computed anew. 8 channels at
// 1 kHz: 10 ms of the event loop.
inline constexpr double kLongestLess_s = 60.0;

// from, to: s on the traces' axis; negative: before the newest record.
[[nodiscard]] HttpReply traces_answer(const ServiceView& view, std::string_view query);

// The data of the event `traces`: the bins of 20 ms from number `first` on that are complete and kept. One line.
[[nodiscard]] std::string traces_event(const Traces& traces, std::int64_t first, std::size_t channels);

}  // namespace dwell
