// A run file and the selected stretch of it: the whole run, one dwell, or a range of time. Exports and report read from
// it.
//
// Bound to one thread. Memory: that of RunReader, three blocks of the stream, whatever the file's size.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/rig_file.hpp"
#include "core/stream/record.hpp"
#include "daemon/record/audit.hpp"
#include "daemon/record/run_reader.hpp"

namespace dwell::handon {

template <class T>
using Result = record::Result<T>;
// Called now and then with the share of the work that is done, 0 … 1. Empty: not wanted.
using Progress = std::function<void(double)>;

// Which part of a run. Seconds on the run's axis: 0 is the first record that the pipeline took. Both ends are included.
// Nothing set: the whole run. `dwell` selects from the dwell's start_s to its end_s.
struct Range {
  std::optional<double> from_s, to_s;
  std::optional<int> dwell;  // its index; excludes the others
};

class Selection {
 public:
  // Fails with "FILE: what is wrong, what was expected", also if the rig file in it cannot be read.
  [[nodiscard]] static Result<Selection> open(const std::string& path, const Range& range);

  // The whole run, for a report, also where its rig file or the begin of its stream cannot be read: unreadable() says
  // what. Fails only if the file cannot be read as a run.
  [[nodiscard]] static Result<Selection> open_damaged(const std::string& path);
  [[nodiscard]] const std::vector<std::string>& unreadable() const noexcept { return unreadable_; }
  // false: open_damaged() could not read the rig file. rig() then has the run's channels by name, and nothing else:
  // their readings are the devices' own numbers.
  [[nodiscard]] bool has_rig() const noexcept { return has_rig_; }

  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] const record::RunHeader& header() const noexcept { return reader_.header(); }
  [[nodiscard]] const std::optional<record::RunEnd>& end() const noexcept { return reader_.end(); }
  [[nodiscard]] std::string ended_utc() const { return reader_.ended_utc(); }  // RunReader::ended_utc()
  // As it was recorded; its channels are those of the stream.
  [[nodiscard]] const config::RigFile& rig_file() const noexcept { return rig_; }
  [[nodiscard]] const Rig& rig() const noexcept { return rig_.rig; }
  [[nodiscard]] record::RunReader& reader() noexcept { return reader_; }

  // Zero of the run's axis, and the stretch's ends, on the clock that recorded.
  [[nodiscard]] std::int64_t zero_ns() const noexcept { return zero_ns_; }
  [[nodiscard]] std::int64_t from_ns() const noexcept { return from_ns_; }
  [[nodiscard]] std::int64_t to_ns() const noexcept { return to_ns_; }
  [[nodiscard]] double axis_s(std::int64_t t_ns) const noexcept { return static_cast<double>(t_ns - zero_ns_) * 1e-9; }

  // Hands every sample of the stretch to `take`, in the stream's order, as long as that returns true; its channel is
  // one of the rig's.
  [[nodiscard]] Result<void> samples(const std::function<bool(const Record&)>& take, const Progress& progress = {});
  // Every record of the stretch.
  [[nodiscard]] Result<void> records(const std::function<bool(const Record&)>& take, const Progress& progress = {});
  // Whether a dwell from start_s to end_s overlaps the stretch.
  [[nodiscard]] bool overlaps(double start_s, double end_s) const noexcept;

 private:
  Selection(std::string path, record::RunReader reader) : path_(std::move(path)), reader_(std::move(reader)) {}
  [[nodiscard]] Result<void> read_rig();
  [[nodiscard]] Result<void> find_zero();
  [[nodiscard]] Result<void> narrow(const Range& range);

  std::string path_;
  record::RunReader reader_;
  config::RigFile rig_;
  bool has_rig_ = true;
  std::vector<std::string> unreadable_;
  std::int64_t zero_ns_ = 0, from_ns_ = 0, to_ns_ = 0;
};

// What an export or a report states about its origin.
struct Provenance {
  std::string program;   // "dwellctl 0.1.0"
  std::string made_utc;  // ISO 8601
  std::string head;      // of the file's last entry, hexadecimal; empty: not known
  std::string audit;     // one line: "intact, key 1a2b … not trusted"; "not audited"
};

// The head, or "not checked".
[[nodiscard]] std::string head_text(const Provenance& provenance);

// Of the computer that recorded: "synchronized within 0.02 s", "not synchronized", "in an unknown state".
[[nodiscard]] std::string clock_text(const record::Origin& origin);

// The audit in one line, as the exports carry it.
[[nodiscard]] std::string audit_line(const record::Audit& audit);

// A reading in its channel's unit, and in SI.
[[nodiscard]] inline double in_unit(const Channel& channel, double raw) noexcept {
  return channel.scale * raw + channel.offset;
}
[[nodiscard]] inline double in_si(const Channel& channel, double raw) noexcept {
  return channel.si_per_unit * in_unit(channel, raw);
}

// "the table", "mass 2", "the ground".
[[nodiscard]] std::string place_text(int at);
// "displacement of mass 2 relative to mass 1".
[[nodiscard]] std::string measurand_text(const Channel& channel);

}  // namespace dwell::handon
