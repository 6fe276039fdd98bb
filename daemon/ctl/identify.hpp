// A recording through the service's own pipeline, in order and as fast as it goes: what `dwellctl identify` does, and
// what tests and benches call.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "core/result/condition.hpp"
#include "core/result/dwell.hpp"
#include "core/result/motion.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/verification_readings.hpp"
#include "daemon/ctl/record_source.hpp"
#include "drivers/replay/csv_recording.hpp"

namespace dwell::ctl {

// How a recording's columns and a rig's channels match, by name.
struct ColumnMatch {
  std::vector<int> channel_of_column;         // index into Rig::channels; -1: the rig does not know the column
  std::vector<std::string> unknown_columns;   // ignored
  std::vector<std::string> missing_channels;  // channels without a column, auxiliary ones left out
};
[[nodiscard]] ColumnMatch match_columns(const Rig& rig, const CsvRecording& recording);

// Every dwell of the recording, in order, also those that did not settle; empty: no drive was ever seen. Values are raw
// (the rig's scale, offset and unit apply); times are on the recording's own axis. readings, if given: receives those
// that count. at_fault, if given: receives the channels whose readings are at fault in some dwell
// (readings_at_fault.hpp), each with what is wrong, as MotionOptions::at_fault has it. The rig must be valid. The
// pipeline's cost per sample; bound to one thread.
[[nodiscard]] tl::expected<std::vector<Dwell>, std::string> identify(const Rig& rig, const RecordSource& source,
                                                                     const Progress& progress = {},
                                                                     VerificationReadings* readings = nullptr,
                                                                     std::vector<ChannelFault>* at_fault = nullptr);

// The coefficients of any motion from a recording. at_fault: as identify() gives it. Takes seconds.
[[nodiscard]] tl::expected<MotionEstimate, std::string> identify_motion(const Rig& rig, const RecordSource& source,
                                                                        std::vector<ChannelFault> at_fault = {});

// The same of a recording as text, on its own t axis.
[[nodiscard]] std::vector<Dwell> identify(const Rig& rig, const CsvRecording& recording);
[[nodiscard]] MotionEstimate identify_motion(const Rig& rig, const CsvRecording& recording);

}  // namespace dwell::ctl
