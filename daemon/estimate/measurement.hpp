// The pipeline of one run, which works in slices, and what comes of it: the dwells that have ended, and the events that
// tell of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/dwell/paced_pipeline.hpp"
#include "core/rig/rig.hpp"
#include "daemon/estimate/kept_dwells.hpp"
#include "daemon/estimate/snapshot.hpp"

namespace dwell {

// Bound to the estimation thread. Real-time safe but where a dwell or a state ends.
class Measurement {
 public:
  using Tell = std::function<void(RunEvent)>;
  // What became of the samples of a channel that the pipeline has been given.
  struct Fate {
    std::uint64_t used = 0;
    std::uint64_t rejected = 0;
  };

  // The rig must be valid. kept: the finished dwells that stay in memory.
  Measurement(const Rig& rig, KeptDwells kept, Tell tell);

  // The next record of the ordered stream.
  void take(const Record& record);
  // Takes samples and ticks from the front of `records`, as take() would one by one. Stops where a dwell may end or
  // the state change. Returns how many it took; 0: take() must take the next one. Costs less than take().
  [[nodiscard]] std::size_t take_samples(std::span<const Record> records) noexcept;
  // How many records have been taken.
  [[nodiscard]] std::uint64_t taken() const noexcept { return taken_; }
  // The end of the run: what waits is done, the current dwell completes.
  void finish();

  // What is live of the channels: channel() and condition_reason() alone may be asked of it at any time.
  [[nodiscard]] const Pipeline& pipeline() const noexcept { return pipeline_.pipeline(); }
  // The dwell as it stands; while a long piece of work goes on, as it stood before. Allocates.
  [[nodiscard]] const Dwell& current();
  // taken() as it was when current() last looked at the pipeline.
  [[nodiscard]] std::uint64_t current_at() const noexcept { return current_at_; }
  // The newest readings that count; null while a long piece of work goes on.
  [[nodiscard]] const SampleHistory* readings() const noexcept {
    return pipeline_.busy() ? nullptr : &pipeline().readings();
  }
  // The state that the newest event gave.
  [[nodiscard]] State state() const noexcept { return state_; }
  // Whether a long piece of work is in progress; how many records wait for it.
  [[nodiscard]] bool busy() const noexcept { return pipeline_.busy(); }
  [[nodiscard]] std::size_t waiting() const noexcept { return pipeline_.waiting(); }
  [[nodiscard]] const KeptDwells& finished() const noexcept { return finished_; }
  [[nodiscard]] Fate fate(std::size_t channel) const noexcept;

 private:
  void note(std::uint8_t change);

  PacedPipeline pipeline_;
  Dwell current_;
  std::uint64_t taken_ = 0, current_at_ = 0;  // records
  State state_ = State::idle;                 // the last that was told
  KeptDwells finished_;
  Tell tell_;
};

}  // namespace dwell
