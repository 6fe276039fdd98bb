// The dwell of the interface's document as a struct: what the tests of JSON, tables and commands are about.
#pragma once

#include "core/result/motion.hpp"
#include "daemon/report/motion_report.hpp"

namespace dwell::test {

// Three channels of which one is stale, three elements of which one is not identifiable; measuring.
[[nodiscard]] Rig sample_rig();
[[nodiscard]] Dwell sample_dwell();
// The same rig before it has settled: no elements, NaN wherever nothing is known.
[[nodiscard]] Dwell settling_dwell();
[[nodiscard]] RunInfo sample_run();
// Coefficients of the same rig from 3.2 s of its transient.
[[nodiscard]] MotionEstimate sample_motion();
// The settling dwell with these beside it, and the measured one with them and the verdict on its model.
[[nodiscard]] DwellView settling_view();
[[nodiscard]] DwellView measured_view(double e_n);
[[nodiscard]] Verification sample_verification();

}  // namespace dwell::test
