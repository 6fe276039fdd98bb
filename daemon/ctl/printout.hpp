// Prints the dwells of a recording, for `identify` and `replay`, and gives their exit code. Heavy: include it in .cpp
// only.
#pragma once

#include <string>
#include <vector>

#include "daemon/ctl/record_source.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell::ctl {

// The printout as JSON and as text; the verbs add members and lines.
struct Printout {
  Json document;
  std::string text;
};
// {"rig": …, "dwells": […]}, or a table of each.
[[nodiscard]] Printout printout(const Rig& rig, const RunInfo& info, const std::vector<Dwell>& dwells);
// To standard output.
void print(const Printout& out, bool json);

// Whether the dwell gives a coefficient that may be used.
[[nodiscard]] bool answers(const Dwell& dwell);
// kDone; or kNo, with the reason on standard error why the dwells give no coefficients. source: where they come from.
[[nodiscard]] int judge(const Rig& rig, const RecordSource& source, const std::vector<Dwell>& dwells);

}  // namespace dwell::ctl
