// The stream of a run file as records for a pipeline, and the rig that goes with it.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/ctl/record_source.hpp"
#include "daemon/record/run_reader.hpp"

namespace dwell::ctl {

// Whether the file is an SQLite database, as run files are, by its first bytes; false: it is something else, or cannot
// be read.
[[nodiscard]] bool is_run_file(const std::string& path);

// Why a child file cannot be computed from: one line.
[[nodiscard]] std::string why_no_stream(const std::string& path, const record::RunHeader& child);

// The rig of the run itself, from the text in the file. Fails with one line.
[[nodiscard]] tl::expected<config::RigFile, std::string> rig_of(const record::RunHeader& header,
                                                                const std::string& path);

// Record::channel of a run's records as index into the channels of a rig that has the same ones by name, in any order.
class ChannelMap {
 public:
  // Fails where the names differ, with those of either side. rig_path, run_path: for that message.
  [[nodiscard]] static tl::expected<ChannelMap, std::string> between(const record::RunHeader& header,
                                                                     const std::string& run_path, const Rig& rig,
                                                                     const std::string& rig_path);
  // The record as the rig has it.
  [[nodiscard]] Record map(Record record) const noexcept;

 private:
  std::vector<std::uint16_t> to_;  // empty: as they are
};

// Every record that concerns a pipeline. Times are on the run's own axis: t = 0 at the first such record.
class RunSource : public RecordSource {
 public:
  RunSource(record::RunReader reader, ChannelMap channels)
      : reader_(std::move(reader)), channels_(std::move(channels)) {}
  [[nodiscard]] tl::expected<void, std::string> play(const Progress& progress, const Take& take) const override;

 private:
  mutable record::RunReader reader_;  // reading it moves its place in the file, no more
  ChannelMap channels_;
};

}  // namespace dwell::ctl
