// What stands beside a live dwell, for people: coefficients from its transient while it settles, marked so that nobody
// takes them for the dwell's own; whether they agree with these once it has settled; what is known of its model.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <string>
#include <vector>

#include "core/result/verification.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/motion_report.hpp"

namespace dwell {

// The estimate from the transient: "from the transient, 0.0 to 3.2 s, an estimate before the verdict:" above a table of
// the coefficients, or why there are none. The table's own legend stands below it, whatever TextOptions::legend says.
// Empty: nothing is known of the transient, or the dwell has settled.
[[nodiscard]] std::vector<Section> transient_sections(const DwellView& view, const TextOptions& options);

// Whether both contradict each other (Agreement::contradicts). Differences within the stated U are tolerated: instants
// of a polled device are known to its turnaround, and the estimate from the transient ignores that.
[[nodiscard]] bool contradicts(const DwellView& view);
// "the coefficients from the transient, 0.0 to 3.2 s, agree with these: …"; or why it is not known. Empty: they were
// not compared.
[[nodiscard]] std::string agreement_text(const DwellView& view);

// "adequate, off by 1.2 % ± 0.8 % (accuracy 5 %)".
[[nodiscard]] std::string model_text(const ModelVerdict& model);
// "adequate, not consistent, objection": a cell of a table. objection: any motion holds something against the
// dwell.
[[nodiscard]] std::string model_brief(const ModelVerdict& model);

}  // namespace dwell
