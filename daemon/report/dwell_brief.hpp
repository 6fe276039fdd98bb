// A finished dwell in short: its coefficients against time, frequency and amplitude, for those who follow many of them.
// A tenth of the whole object, which has phasors, covariance and budgets. Pure.
#pragma once

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell {

// rig: of the dwell. One without channels: `table` is null.
[[nodiscard]] Json brief_json(const DwellView& dwell, const Rig& rig);

}  // namespace dwell
