// A recording and its rig file, read and checked: the input of `identify`, `verify` and `export`. A run file holds
// both; a recording as text (CSV) needs a rig file beside it.
#pragma once

#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "config/rig_file.hpp"
#include "daemon/ctl/identify.hpp"
#include "daemon/ctl/record_source.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell::ctl {

// Bound to one thread.
class RecordedRun {
 public:
  // data: a run file or CSV. rig: for a run file, another rig file than its own, or empty. Says on standard error what
  // is wrong or ignored. The error is an exit code.
  [[nodiscard]] static tl::expected<RecordedRun, int> load(const std::string& rig, const std::string& data);

  [[nodiscard]] const config::RigFile& file() const noexcept { return *file_; }
  [[nodiscard]] const Rig& rig() const noexcept { return file_->rig; }
  [[nodiscard]] const RecordSource& source() const noexcept { return *source_; }
  // What the results are computed with.
  [[nodiscard]] const RunInfo& info() const noexcept { return info_; }

 private:
  RecordedRun(std::unique_ptr<const config::RigFile> file, std::unique_ptr<const RecordSource> source, RunInfo info)
      : file_(std::move(file)), source_(std::move(source)), info_(std::move(info)) {}
  static tl::expected<RecordedRun, int> from_csv(const std::string& rig, const std::string& data);
  static tl::expected<RecordedRun, int> from_run_file(const std::string& rig, const std::string& data);

  std::unique_ptr<const config::RigFile> file_;  // the source refers to its rig
  std::unique_ptr<const RecordSource> source_;
  RunInfo info_;
};

// One line on standard error, without control characters.
void tell_error(const std::string& text);

// Why there is nothing to show of these dwells, in one line.
[[nodiscard]] std::string why_nothing_settled(const Rig& rig, const RecordSource& source,
                                              const std::vector<Dwell>& dwells);

}  // namespace dwell::ctl
