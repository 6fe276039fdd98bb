// Decides which reading of a device an arrival is. It is the next one, unless it came later than even the reading after
// that could have come.
//
// Then the arrival is either late or follows a loss. It waits, with those after it, until the evidence decides. One
// arrival as early as only the next reading can be proves that nothing was lost. Many arrivals without such a one prove
// a loss. The evidence is the likelihood of each arrival under the delays learnt so far, for each possible number of
// lost readings.
//
// Fixed storage, no allocation. Bound to one thread; real-time safe.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/stream/arrival_grid.hpp"
#include "core/stream/clock_tracker.hpp"
#include "core/stream/held_arrivals.hpp"

namespace dwell {

class LossJudge {
 public:
  // Begins on a grid whose last arrival was at newest_ns.
  void begin(const ArrivalGrid& grid, std::int64_t newest_ns) noexcept;

  struct Verdict {
    std::size_t settled = 0;  // so many of the waiting readings follow each other without a loss
    int lost = 0;             // readings lost after these; negative: so many were counted that do not exist
  };
  // Judges the waiting readings. Both 0: wait for more. at_once: decides on the evidence so far.
  [[nodiscard]] Verdict judge(const HeldArrivals& held, const ClockTracker& clock, bool at_once) const noexcept;

  // A reading was decided: it arrived at arrival_ns, `late` periods late.
  void learn(std::int64_t arrival_ns, double late) noexcept;
  // The numbering was corrected by a verdict's `lost`.
  void count(int lost) noexcept;
  // Whether more was lost, or taken back, than is possible if the clock is followed correctly.
  [[nodiscard]] bool implausible() const noexcept;

 private:
  DelayShape shape_;
  std::int64_t previous_arrival_ns_ = 0;  // of the last decided reading
  double lost_part_ = 0.0;                // part of the recent readings before which a loss was counted
  double too_early_ = 0.0;                // recent readings taken back in excess of the losses counted before
};

}  // namespace dwell
