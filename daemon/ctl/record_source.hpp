// The records of a recording in the order in which the pipeline takes them, whatever the kind of file.
#pragma once

#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "core/rig/rig.hpp"
#include "daemon/ctl/progress.hpp"
#include "drivers/replay/csv_recording.hpp"

namespace dwell {
struct Record;
}

namespace dwell::ctl {

// Bound to one thread.
class RecordSource {
 public:
  using Take = std::function<void(const Record&)>;

  virtual ~RecordSource() = default;
  // Hands every record to `take`; Record::channel is an index into Rig::channels. Times are on the axis of the
  // recording's results. May be called again. Fails with "FILE: what is wrong", possibly after some records.
  [[nodiscard]] virtual tl::expected<void, std::string> play(const Progress& progress, const Take& take) const = 0;
};

// A recording as text: samples only, as they are stamped. Samples of a device with its own clock get the recovered
// instants. Columns that are not in the rig are skipped. Never fails.
class CsvSource : public RecordSource {
 public:
  // The rig must outlive this.
  CsvSource(const Rig& rig, CsvRecording recording) : rig_(rig), recording_(std::move(recording)) {}
  [[nodiscard]] tl::expected<void, std::string> play(const Progress& progress, const Take& take) const override;

 private:
  const Rig& rig_;
  CsvRecording recording_;
};

}  // namespace dwell::ctl
