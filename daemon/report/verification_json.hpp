// A verification as a JSON value, the object of the public interface: `verify`, GET /api/v1/verification.
//
// Beyond the interface's fields: `dwell` (its index), `cannot_be_checked`, and per channel `verdict`, `samples`, `rms`,
// `unit`, `noise` and `beyond_steady`. Heavy: include it in .cpp only. Bound to one thread, not real-time: allocates.
#pragma once

#include <string>
#include <tl/expected.hpp>

#include "core/result/verification.hpp"
#include "core/rig/rig.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/verification_text.hpp"

namespace dwell {

[[nodiscard]] Json json_value(const Verification& verification, const Rig& rig, const Dwell& dwell);
// The way back. Members that are not known are ignored; one that is missing or of another type is named in the error.
[[nodiscard]] tl::expected<VerificationView, std::string> verification_from_json(const Json& value);

}  // namespace dwell
