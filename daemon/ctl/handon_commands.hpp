// export and report: a recorded run for other programs and for the archive.
#pragma once

#include <string>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "daemon/handon/selection.hpp"

namespace dwell::ctl {

struct ExportRunOptions {
  std::string file;
  std::string format;  // "csv", "hdf5" or "uff"
  std::string output;
  bool overwrite = false;  // an existing file of that name
  handon::Range range;
  bool in_unit = false;           // csv: also in the channel's unit
  bool binary = false;            // uff: 58b
  bool unchecked = false;         // without an audit
  std::vector<std::string> keys;  // pinned, see pinned_keys()
  bool json = false;
};

struct ReportOptions {
  std::string file;
  std::string output;
  bool overwrite = false;            // an existing file of that name
  std::vector<std::string> keys;     // pinned, see pinned_keys()
  std::vector<std::string> persons;  // pinned too: keys of persons
  std::string ledger;                // for the audit; empty: none
  bool json = false;
};

// Refuses a file that was tampered with, with exit code 1. With `unchecked` it exports the readable part, and the
// export says that it was not audited.
[[nodiscard]] int export_run(const ExportRunOptions& options);
// If the file was tampered with, the report says so, and the exit code is 1.
[[nodiscard]] int report(const ReportOptions& options);

}  // namespace dwell::ctl
