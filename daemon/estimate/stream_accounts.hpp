// What has become of the samples of each channel since the session began, whichever pipelines took them.
//
// Every sample of the stream counts once: it was taken by the pipeline that was shown when it came. Pipelines come and
// go; the counts go on.
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

  // A record of the stream, before any pipeline takes it.
  void give(const Record& record) noexcept {
    if (record.kind == Kind::sample && record.channel < given_.size()) ++given_[record.channel];
  }
  // From here on this pipeline is shown. Nothing may wait in it, nor in the one shown before; both must live.
  void follow(const RunPipeline& shown) noexcept;

  // By Rig::channels index: samples of the stream so far.
  [[nodiscard]] const std::vector<std::uint64_t>& given() const noexcept { return given_; }
  // What became of the samples of a channel; both numbers only grow.
  [[nodiscard]] Measurement::Fate fate(std::size_t channel) const noexcept;
  // How often samples of it were lost.
  [[nodiscard]] std::uint64_t gaps(std::size_t channel) const noexcept;

 private:
  // Of the pipelines before the one shown, less what that one had counted itself by then.
  struct Carried {
    std::uint64_t rejected = 0, gaps = 0;
  };

  std::vector<std::uint64_t> given_;
  std::vector<Carried> carried_;
  const RunPipeline* shown_ = nullptr;
};

}  // namespace dwell
