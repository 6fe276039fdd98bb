// Counts what became of the samples of each channel since the session began, whichever pipelines took them.
//
// Every sample of the stream counts once, by what the pipeline shown at that time did with it. Pipelines come and go;
// the counts go on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "daemon/estimate/run_pipeline.hpp"

namespace dwell {

// Bound to the estimation thread. Real-time safe after construction.
class StreamAccounts {
 public:
  explicit StreamAccounts(std::size_t channels) : given_(channels), carried_(channels) {}

  // A record of the stream. Call it before the counts are asked for that include this record.
  void give(const Record& record) noexcept {
    if (record.kind == Kind::sample && record.channel < given_.size()) ++given_[record.channel];
  }
  // From now on this pipeline is shown. No record may wait in it or in the one shown before; both must still exist.
  void follow(const RunPipeline& shown) noexcept;

  // By Rig::channels index: samples of the stream so far.
  [[nodiscard]] const std::vector<std::uint64_t>& given() const noexcept { return given_; }
  // What became of the samples of a channel; both numbers only grow.
  [[nodiscard]] Measurement::Fate fate(std::size_t channel) const noexcept;
  // How often samples of it were lost.
  [[nodiscard]] std::uint64_t gaps(std::size_t channel) const noexcept;

 private:
  // Sums of the pipelines shown before, less what the current one had counted when it was shown.
  struct Carried {
    std::uint64_t rejected = 0, gaps = 0;
  };

  std::vector<std::uint64_t> given_;
  std::vector<Carried> carried_;
  const RunPipeline* shown_ = nullptr;
};

}  // namespace dwell
