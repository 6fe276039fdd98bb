// Which reading of a device is an arrival? It is taken for the next one, unless it came later than even the reading
// after that could have come.
//
// Then it is either late or follows a loss. It and those after it wait until one of them shows that nothing was lost
// (it is as early as only the next reading can be), or until so many have come, none of them showing it, that a loss is
// beyond doubt.
// The evidence is the likelihood of each arrival under the delays learnt so far, for each number of readings that may
// have been lost.
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
    std::size_t settled = 0;  // so many of those waiting follow each other without a loss
    int lost = 0;             // readings lost after them; negative: so many too many were counted
  };
  // Of those that wait. at_once: on the evidence there is; else nothing settled and nothing lost means: wait for more.
  [[nodiscard]] Verdict judge(const HeldArrivals& held, const ClockTracker& clock, bool at_once) const noexcept;

  // A reading was decided upon: it arrived then, so many periods late.
  void learn(std::int64_t arrival_ns, double late) noexcept;
  // The numbering was put right by a verdict's `lost`.
  void count(int lost) noexcept;
  // More was lost, or taken back, than a clock that is followed rightly explains.
  [[nodiscard]] bool implausible() const noexcept;

 private:
  DelayShape shape_;
  std::int64_t previous_arrival_ns_ = 0;  // of the last reading decided on
  double lost_part_ = 0.0;                // of the readings, recently
  double too_early_ = 0.0;                // numbers taken back beyond the losses counted before, recently
};

}  // namespace dwell
