// A rig file and a recording that goes with it, read and checked: what `identify`, `verify` and `export` begin with.
#pragma once

#include <string>
#include <tl/expected.hpp>

#include "config/rig_file.hpp"
#include "daemon/ctl/identify.hpp"
#include "drivers/replay/csv_recording.hpp"

namespace dwell::ctl {

struct RecordedRun {
  config::RigFile file;
  CsvRecording recording;
};

// One line on standard error, without control characters.
void tell_error(const std::string& text);

// Says on standard error what is wrong, or what is ignored. The error: an exit code.
[[nodiscard]] tl::expected<RecordedRun, int> load_recorded_run(const std::string& rig, const std::string& data);

// Why there is nothing to show of these dwells, in one line.
[[nodiscard]] std::string why_nothing_settled(const Rig& rig, const CsvRecording& recording,
                                              const std::vector<Dwell>& dwells);

}  // namespace dwell::ctl
