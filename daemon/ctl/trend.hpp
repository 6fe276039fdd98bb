// How each coefficient has moved since watch began, an hour at most, drawn as a line of block characters:
//
//   trend of the last 12 min; middle: the newest value, top and bottom: ± what stands beside, at least twice its U95
//   element  stiffness                       damping
//         1  ▄▄▄▄▅▅▄▄▄▄▅▄▄▄▄▄▄▄▄▄  ± 0.20 %  ▃▃▃▄▄▄▄▄▅▅▅▄▄▄▄▄▄▄▄▄  ± 2.6 %
//
// That ± is twice the U95 of the newest value, or more where a value was further away. Where it is not more, the four
// middle heights of eight are the newest ± U95. A blank: no coefficient was given then.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "daemon/report/dwell_view.hpp"
#include "daemon/report/line.hpp"

namespace dwell::ctl {

inline constexpr std::string_view kTrend = "trend";

class Trend {
 public:
  static constexpr double kSpan_s = 3600.0;
  // A line has 20 blocks. Every 3 s, a minute fills them; 1200 points make an hour.
  static constexpr double kEvery_s = 3.0;
  static constexpr std::size_t kBlocks = 20;

  // The dwell as it stands; one whose coefficients are not given leaves a blank. now_s: never less than before.
  void take(const DwellView& view, double now_s);

  // A line for each element that has coefficients in `view`; empty: there is none, or nothing has been seen before.
  // A table cell holds 20 blocks, so a line is 76 columns wide; where fewer are to be had, damping stands on a line of
  // its own.
  [[nodiscard]] Section section(const DwellView& view, double now_s, std::size_t columns) const;

 private:
  struct Point {
    double t_s;
    std::vector<double> stiffness, damping;  // one per element; NaN: none
  };

  // Of element k (0 …) in each of the blocks, oldest first; NaN: none.
  [[nodiscard]] std::vector<double> in_blocks(std::vector<double> Point::*which, std::size_t element, double from_s,
                                              double until_s) const;

  std::deque<Point> points_;  // oldest first; kEvery_s apart, but for the newest, which is replaced until then
};

// The blocks of a line: `middle` stands between the fourth and the fifth of eight heights, middle ± reach at the edges.
[[nodiscard]] std::string sparkline(const std::vector<double>& values, double middle, double reach);

}  // namespace dwell::ctl
