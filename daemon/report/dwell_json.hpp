// The dwell object of the public interface as text: the same object in `identify`, over HTTP and wherever it is stored.
//
// SI units. A number that does not exist (NaN, infinite) is null. `index` is null while idle, `ended_by` is there only
// for a complete dwell, `elements` is empty until the dwell has settled; then `warnings` says why. An element that is
// not identifiable has `stiffness`, `damping` and `loss_factor` null and a `reason`, as has a channel without a valid
// phasor. Beyond the interface's fields: `settling_reason`, `memory_time_predicted_s`; per phasor
// `u_relative_phase_rad` (of the phase against the first valid channel's, without what both share), `sigma` (standard
// deviation of the residuals), `samples`, `valid`. `limits` is there where the rig file has any; `estimate_age_s`,
// `stale` and `moved_beyond` of a live dwell alone.
//
// Bound to one thread, not real-time: allocates. No function throws on what the data hold.
#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "daemon/report/dwell_view.hpp"

namespace dwell {

// One line, no spaces between.
[[nodiscard]] std::string to_json(const Dwell& dwell, const Rig& rig, const RunInfo& run);
[[nodiscard]] std::string to_json(const DwellView& view);

// The way back. Fields that are not known are ignored; one that is missing or has the wrong type is named in the error.
[[nodiscard]] tl::expected<DwellView, std::string> parse_dwell(std::string_view text);

}  // namespace dwell
