// A recording, whatever its file: its records in the order in which the pipeline takes them.
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
  // Hands every record to `take`, Record::channel an index into Rig::channels. Times are on the axis on which the
  // recording's results are told. May be called again. Fails with "FILE: what is wrong", after some records perhaps.
  [[nodiscard]] virtual tl::expected<void, std::string> play(const Progress& progress, const Take& take) const = 0;
};

// A recording as text: samples alone, as they are stamped. Where a device of the rig has a clock of its own they come
// at the recovered instants. Columns that the rig does not know are passed over. Never fails.
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
