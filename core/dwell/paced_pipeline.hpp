// A pipeline whose push() never takes long: it does long work in slices.
//
// The fits of the transient pass over all samples of a hold, some hundred milliseconds in a large rig. The caller has
// rings to drain. So a push does a bounded amount of work, and the next push continues it. Records that come meanwhile
// wait in order. The pipeline sees the same stream and gives the same dwells to the bit, only later. The work allowed
// is counted from the records' instants, ticks included, never from the processor's time. So the same stream gives each
// dwell at the same record on every machine.
//
// An edge of the interlock or an operator's action must not wait for a fit: work has no limit until that record is
// taken.
//
// Not in slices, and so the least that a push may take: the eigenvalues of a chain, one channel's solution, the result
// of a dwell that ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/slices.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"

namespace dwell {

// Bound to one thread. The constructor allocates everything: as many records of 32 bytes as a pipeline keeps samples,
// 16 MB at most.
class PacedPipeline {
 public:
  // Work allowed in multiplications: for each second of the stream (half a second to a second of a processor), and at
  // most in one push (two milliseconds).
  static constexpr double kPerSecond = 2e9, kAtOnce = 4e6;

  // The rig must be valid.
  explicit PacedPipeline(const Rig& rig);
  ~PacedPipeline();
  PacedPipeline(const PacedPipeline&) = delete;
  PacedPipeline& operator=(const PacedPipeline&) = delete;

  // Hands in the next record of the stream. Takes this record, or up to two that wait, the oldest first; all up to an
  // urgent one. Stops at the first Change and returns it. Real-time safe unless a dwell ends.
  std::uint8_t push(const Record& record) noexcept;
  // As Pipeline::push_in_block(). Returns 0 while records wait.
  std::size_t push_in_block(std::span<const Record> records) noexcept;
  // At the end of the run, until waiting() is 0: takes what waits, up to the first Change. Unlimited work.
  std::uint8_t flush() noexcept;
  // As Pipeline::finish(); only when waiting() is 0.
  std::uint8_t finish();

  // While busy() only channel() and condition_reason() may be called.
  [[nodiscard]] const Pipeline& pipeline() const noexcept { return pipeline_; }
  [[nodiscard]] bool busy() const noexcept { return slices_.busy(); }
  [[nodiscard]] std::size_t waiting() const noexcept { return count_; }
  // Multiplications by which the last push exceeded what it was allowed.
  [[nodiscard]] double overdrawn() const noexcept { return slices_.overdrawn(); }
  // How many samples of a channel the pipeline has taken.
  [[nodiscard]] std::uint64_t taken(std::size_t channel) const noexcept { return taken_[channel]; }

 private:
  void earn(std::int64_t t_ns) noexcept;
  void append(const Record& record) noexcept;
  bool take_next() noexcept;
  void take(const Record& record) noexcept;
  void count(const Record& record) noexcept {
    if (record.kind == Kind::sample && record.channel < taken_.size()) ++taken_[record.channel];
  }

  Slices slices_;
  Pipeline pipeline_;
  std::vector<std::uint64_t> taken_;  // by Rig::channels index
  std::vector<Record> ring_;          // records that wait; while busy the oldest is in work
  std::size_t first_ = 0, count_ = 0;
  std::size_t urgent_ = 0;           // number of these up to the newest urgent one
  std::uint8_t changes_ = kNothing;  // of the record taken last
  std::int64_t newest_ns_ = INT64_MIN;
};

}  // namespace dwell
