// A pipeline that holds nobody up: what takes long, it does in slices.
//
// The fits of the transient go over all samples of a hold, for some hundred milliseconds in a large rig. Whoever feeds
// the pipeline has rings to drain. So a push does a bounded amount of work. What is not done goes on at the next push;
// records that come meanwhile wait, and are taken in order once it is done. The pipeline itself sees the same stream as
// ever: the same dwells to the bit, told a little later. How much a push may do grows with the time of the stream,
// ticks included, and not with the time it takes: so the same stream is also told at the same records.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/slices.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"

namespace dwell {

// Bound to one thread. Everything is allocated by the constructor.
class PacedPipeline {
 public:
  // Multiplications for each second of the stream (half of what a slow processor does in a second), and at most in one
  // push: a millisecond.
  static constexpr double kPerSecond = 2e9, kAtOnce = 4e6;

  // The rig must be valid.
  explicit PacedPipeline(const Rig& rig);
  ~PacedPipeline();
  PacedPipeline(const PacedPipeline&) = delete;
  PacedPipeline& operator=(const PacedPipeline&) = delete;

  // Pipeline::push() of this record, or of one that waits. At most one of them brings about a Change. Real-time safe
  // but where a dwell ends.
  std::uint8_t push(const Record& record) noexcept;
  // At the end of the run, until nothing waits: what the records that wait bring about, one Change after the other.
  // Takes as long as it takes. Then finish().
  std::uint8_t flush() noexcept;
  std::uint8_t finish() { return pipeline_.finish(); }

  // While busy, state() and channel() may be asked, nothing else.
  [[nodiscard]] const Pipeline& pipeline() const noexcept { return pipeline_; }
  [[nodiscard]] bool busy() const noexcept { return slices_.busy(); }
  [[nodiscard]] std::size_t waiting() const noexcept { return count_; }
  // By how much the push before exceeded kAtOnce, multiplications.
  [[nodiscard]] double overdrawn() const noexcept { return slices_.overdrawn(); }
  // Samples of a channel that the pipeline has been given.
  [[nodiscard]] std::uint64_t taken(std::size_t channel) const noexcept { return taken_[channel]; }

 private:
  bool take_next() noexcept;
  void make_room() noexcept;
  void take(const Record& record) noexcept;

  Slices slices_;
  Pipeline pipeline_;
  std::vector<std::uint64_t> taken_;  // by Rig::channels
  std::vector<Record> ring_;          // of records that wait; the oldest is the one in work, while busy
  std::size_t first_ = 0, count_ = 0;
  std::uint8_t changes_ = kNothing;  // of the record taken last
  std::int64_t newest_ns_ = INT64_MIN;
};

}  // namespace dwell
