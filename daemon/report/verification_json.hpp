// A verification as a JSON value, the object of the public interface: `verify`, GET /api/v1/verification.
//
// Beyond the interface's fields: `dwell` (its index), `cannot_be_checked`, and per channel `verdict`, `samples`, `rms`,
// `unit`, `noise` and `beyond_steady`. Heavy: include it in .cpp only. Bound to one thread, not real-time: allocates.
#pragma once

#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell {

[[nodiscard]] Json json_value(const Verification& verification, const Rig& rig, const Dwell& dwell);

}  // namespace dwell
