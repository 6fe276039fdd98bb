// What `identify` and `replay` print of the dwells of a recording, and their exit code. Heavy: include it in .cpp only.
#pragma once

#include <string>
#include <vector>

#include "daemon/ctl/record_source.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell::ctl {

// Both forms; further members and lines may be added.
struct Printout {
  Json document;
  std::string text;
};
// {"rig": …, "dwells": […]}, or a table of each.
[[nodiscard]] Printout printout(const Rig& rig, const RunInfo& info, const std::vector<Dwell>& dwells);
// To standard output.
void print(const Printout& out, bool json);

// Whether some coefficient may be taken from it.
[[nodiscard]] bool answers(const Dwell& dwell);
// kDone, or kNo after saying on standard error why the dwells give no coefficients. source: they come from it.
[[nodiscard]] int judge(const Rig& rig, const RecordSource& source, const std::vector<Dwell>& dwells);

}  // namespace dwell::ctl
