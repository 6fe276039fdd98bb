// A pipeline that holds nobody up: what takes long, it does in slices.
//
// The fits of the transient go over all samples of a hold, for some hundred milliseconds in a large rig. Whoever feeds
// the pipeline has rings to drain. So a push does a bounded amount of work; what is not done goes on at the next push.
// Records that come meanwhile wait, and are taken in order once it is done. The pipeline itself sees the same stream as
// ever: the same dwells to the bit, told later. What a push may do is counted from the records' instants, ticks
// included, never from the processor's time: so the same stream is also told at the same records.
//
// An edge of the interlock or an operator's action must not wait for a fit: from then on work has no limit, until that
// record has been taken.
//
// Not in slices, and so the least that a push may take: the eigenvalues of a chain, one channel's solution, the result
// of a dwell that ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/slices.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"

namespace dwell {

// Bound to one thread. Everything is allocated by the constructor: as many records of 32 bytes as a pipeline keeps
// samples, 16 MB at most.
class PacedPipeline {
 public:
  // Multiplications for each second of the stream (what a processor does in half a second to a second), and at most
  // in one push: two milliseconds.
  static constexpr double kPerSecond = 2e9, kAtOnce = 4e6;

  // The rig must be valid.
  explicit PacedPipeline(const Rig& rig);
  ~PacedPipeline();
  PacedPipeline(const PacedPipeline&) = delete;
  PacedPipeline& operator=(const PacedPipeline&) = delete;

  // The next record of the stream. Takes it, or up to two that wait, the oldest first; what Pipeline::push() says of
  // these. At most one brings about a Change. Real-time safe but where a dwell ends.
  std::uint8_t push(const Record& record) noexcept;
  // At the end of the run, until waiting() is 0: takes what waits, up to the first Change. Takes as long as it takes.
  std::uint8_t flush() noexcept;
  // After that.
  std::uint8_t finish();

  // While busy() ask for nothing but channel() and condition_reason().
  [[nodiscard]] const Pipeline& pipeline() const noexcept { return pipeline_; }
  [[nodiscard]] bool busy() const noexcept { return slices_.busy(); }
  [[nodiscard]] std::size_t waiting() const noexcept { return count_; }
  // By how much the push before exceeded what it was allowed, multiplications.
  [[nodiscard]] double overdrawn() const noexcept { return slices_.overdrawn(); }
  // Samples of a channel that the pipeline has been given.
  [[nodiscard]] std::uint64_t taken(std::size_t channel) const noexcept { return taken_[channel]; }

 private:
  void earn(std::int64_t t_ns) noexcept;
  void append(const Record& record) noexcept;
  bool take_next() noexcept;
  void take(const Record& record) noexcept;

  Slices slices_;
  Pipeline pipeline_;
  std::vector<std::uint64_t> taken_;  // by Rig::channels
  std::vector<Record> ring_;          // of records that wait; while busy the oldest is the one in work
  std::size_t first_ = 0, count_ = 0;
  std::size_t urgent_ = 0;           // of these, up to the newest that must not wait
  std::uint8_t changes_ = kNothing;  // of the record taken last
  std::int64_t newest_ns_ = INT64_MIN;
};

}  // namespace dwell
