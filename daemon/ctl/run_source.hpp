// The stream of a run file as records for a pipeline, and the rig that goes with it.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/ctl/record_source.hpp"
#include "daemon/record/run_reader.hpp"

namespace dwell::ctl {

// Whether the file's first bytes are those of an SQLite database, as run files are; false: they are not, or it cannot
// be read.
[[nodiscard]] bool is_run_file(const std::string& path);

// Why nothing can be computed from a child file: one line.
[[nodiscard]] std::string why_no_stream(const std::string& path, const record::RunHeader& child);

// The run's own rig, from the text in the file. Fails with one line.
[[nodiscard]] tl::expected<config::RigFile, std::string> rig_of(const record::RunHeader& header,
                                                                const std::string& path);

// Maps Record::channel of a run to the channels of a rig that has the same channels by name, in any order.
class ChannelMap {
 public:
  // Fails if the names differ, with the names missing on either side. rig_path, run_path: for that message.
  [[nodiscard]] static tl::expected<ChannelMap, std::string> between(const record::RunHeader& header,
                                                                     const std::string& run_path, const Rig& rig,
                                                                     const std::string& rig_path);
  // Whether the rig has the channels in the run's order: map() changes nothing.
  [[nodiscard]] bool same_order() const noexcept { return to_.empty(); }
  // The record with the rig's channel.
  [[nodiscard]] Record map(Record record) const noexcept {
    const bool of_channel =
        record.kind == Kind::sample || record.kind == Kind::channel_state || record.kind == Kind::loss;
    if (of_channel && record.channel < to_.size()) record.channel = to_[record.channel];
    return record;
  }

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
  mutable record::RunReader reader_;  // reading only moves its place in the file
  ChannelMap channels_;
};

}  // namespace dwell::ctl
