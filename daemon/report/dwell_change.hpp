// What moved between two dwell objects of the same dwell: the `change` event of the live stream, and the way back.
//
// A change holds `index` and `state`, and of all other members those that differ, each with its new value. Of `phasors`
// and `elements` it holds the entries that differ, each with its name (`channel`, `k`) and the members that differ.
// `covariance` and every `budget` are left out: they are most of the text, and come with the next whole object.
// Heavy: include it in .cpp only. Pure; allocates.
#pragma once

#include <optional>

#include "daemon/report/dwell_json_value.hpp"

namespace dwell {

// before, now: as json_value makes them, with Detail::moving or whole. nullopt: more than values differ (another dwell,
// another state, another number of elements, members that came or went), so that the whole object is needed.
[[nodiscard]] std::optional<Json> change_between(const Json& before, const Json& now);

// Brings `dwell` up to date; false, and `dwell` as it was: the change is of another dwell or state, or of another
// shape.
[[nodiscard]] bool apply_change(Json& dwell, const Json& change);

}  // namespace dwell
