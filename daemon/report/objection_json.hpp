// What the last estimate of a dwell that has ended holds against it: the member `objection` of the result of an
// `estimate` entry (docs/run-file.md). Heavy: include it in .cpp only. Thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "core/motion/transient_watch.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell {

struct StoredObjection {
  int dwell = 0;     // its index
  std::string what;  // in words with figures
};

// {"dwell": 3, "what": "…"}; null: it holds nothing against a dwell.
[[nodiscard]] Json json_objection(const TransientEstimate& of);
// result: of the entry. none: nothing is held against a dwell; older files do not have the member. An error says what
// of it is missing or of another type.
[[nodiscard]] tl::expected<std::optional<StoredObjection>, std::string> objection_in(const Json& result);

}  // namespace dwell
