// The dwell of the interface's document as a struct: what the tests of JSON, tables and commands are about.
#pragma once

#include "daemon/report/dwell_view.hpp"

namespace dwell::test {

// Three channels of which one is stale, three elements of which one is not identifiable; measuring.
[[nodiscard]] Rig sample_rig();
[[nodiscard]] Dwell sample_dwell();
// The same rig before it has settled: no elements, NaN wherever nothing is known.
[[nodiscard]] Dwell settling_dwell();
[[nodiscard]] RunInfo sample_run();

}  // namespace dwell::test
