// The estimates by any motion that a run published, each with the readings that it was made from, as a replay comes to
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/motion/transient_watch.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "daemon/ctl/newest_readings.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::ctl {

struct PublishedEstimate {
  record::StoredModel stored;
  TransientEstimate of;  // what it was made from; the estimate itself is empty
};

// Bound to one thread. Memory: 24 bytes for each reading of the largest estimate.
class EstimatesAgain {
 public:
  // A file whose entry names more is not Dwell's: an estimate takes 250 000 (MotionOptions::most_work over the states).
  static constexpr std::size_t kMostReadings = 1'000'000;

  // published: each with at most kMostReadings. The rig's channel numbers are those of the records to come.
  EstimatesAgain(const Rig& rig, std::vector<PublishedEstimate> published);

  // Called when all its readings have come by: the job to be run.
  using Make = std::function<void(record::StoredModel, TransientJob)>;
  // The next record of the stream, its instant on the run's axis, and its position.
  void take(const Record& record, std::int64_t t_ns, std::uint64_t position, const Make& make);
  // Call after the last take(): those without a job. The stream lacks their readings.
  [[nodiscard]] std::vector<PublishedEstimate> left() const;

 private:
  std::vector<bool> counts_;                  // by Rig::channels: all but auxiliary ones
  std::vector<PublishedEstimate> published_;  // by TransientEstimate::last
  std::size_t next_ = 0;
  NewestReadings newest_;
  std::vector<PublishedEstimate> left_;
};

}  // namespace dwell::ctl
