// What is asked of GET /api/v1/traces: from=S, to=S, points=N, channels=NAME,NAME, less=steady. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

struct TracesQuery {
  // As asked: s since the origin. A negative from_s, and then a to_s of 0 or below, count back from the newest record.
  double from_s = -10.0;
  std::optional<double> to_s;         // none: the newest record
  std::int64_t points = 0;            // 0: not asked for
  std::vector<std::size_t> channels;  // indices into Rig::channels, as asked for; never empty
  bool less_steady = false;
};

// Fails with what was found and what was expected.
[[nodiscard]] tl::expected<TracesQuery, std::string> traces_query(std::string_view query, const Rig& rig);

}  // namespace dwell
