// How each coefficient differs from that of the settled dwell before, as the page has it:
//
//   change since dwell 2; moved: by more than chance (one false alarm in 20 dwells)
//   element  stiffness                         damping
//         1  +0.31 ± 0.12 % moved              -0.4 ± 1.9 %
//
// core/result/moved.hpp defines when a coefficient has moved. If a dwell is in the list of ended dwells, its numbers
// there are used, not those told live: they hold no data of after the drive changed.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/ctl/earlier_dwells.hpp"
#include "daemon/report/dwell_view.hpp"
#include "daemon/report/line.hpp"

namespace dwell::ctl {

inline constexpr std::string_view kDeviation = "deviation";

class Deviation {
 public:
  // now_s: s, on one clock that never steps back.

  // The dwell as it stands; one that has not settled is ignored.
  void take(const DwellView& view, double now_s);
  // Dwells that have ended, oldest first.
  void take_earlier(const std::vector<EarlierDwell>& dwells, double now_s);

  // A line for each element that has coefficients in `view`, in the columns of Trend::section(). Empty: there is none,
  // the dwell has ended, or no dwell before it is known.
  [[nodiscard]] Section section(const DwellView& view, double now_s, std::size_t columns) const;

 private:
  struct Settled {
    std::string run;  // its start, UTC
    int index = 0;
    double t_s = 0.0;    // of its newest data
    bool ended = false;  // the service's list, or the dwell itself, tells its end
    std::vector<double> stiffness, stiffness_U95, damping, damping_U95;  // one per element; NaN: none
    [[nodiscard]] bool same(const Settled& other) const { return run == other.run && index == other.index; }
  };
  void put(Settled dwell);

  std::vector<Settled> newest_;  // oldest first, at most two: that in view and the one before
};

}  // namespace dwell::ctl
