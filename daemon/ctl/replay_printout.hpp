// The printout of `replay` beyond that of `identify`. Heavy: include it in .cpp only.
#pragma once

#include <string>

#include "daemon/ctl/printout.hpp"
#include "daemon/ctl/replay_check.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::ctl {

struct ReplayVerdict {
  bool same_origin = false;  // recorded by the same program, build and CPU features: every bit must be the same
  bool same = false;         // no difference is larger than allowed
  record::Origin here;
};
[[nodiscard]] ReplayVerdict judge(const ReplayFindings& findings, const record::Origin& recorded, record::Origin here);

void add(const ReplayVerdict& verdict, const ReplayFindings& findings, const record::RunHeader& run, Printout& to);

// For a replay with another rig file. child: the file that was written; empty: none.
void add_parent(const record::RunHeader& parent, const std::string& child, Printout& to);

}  // namespace dwell::ctl
