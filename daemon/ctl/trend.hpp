// How each coefficient has moved over the last hour, drawn as a line of block characters:
//
//   trend of the last 12 min; middle: newest value, height: ± the % beside
//   element  stiffness                       damping
//         1  ▄▄▄▄▅▅▄▄▄▄▅▄▄▄▄▄▄▄▄▄  ± 0.20 %  ▃▃▃▄▄▄▄▄▅▅▅▄▄▄▄▄▄▄▄▄  ± 2.6 %
//
// The percentage is twice the U95 of the newest value; then the four middle heights of eight are the newest ± U95. It
// is more where an older value was further away. A blank: no coefficient is known of then, as while the connection was
// lost. Of a dwell that ended before watch began, or while its connection was lost, the last value is known; it stands
// for all of the dwell that was not seen.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ctl/earlier_dwells.hpp"
#include "daemon/report/dwell_view.hpp"
#include "daemon/report/line.hpp"

namespace dwell::ctl {

inline constexpr std::string_view kTrend = "trend";

class Trend {
 public:
  static constexpr double kSpan_s = 3600.0;  // older points are dropped
  // Blocks of a line: two lines of 20 with their percentages fit beside each other in 80 columns.
  static constexpr std::size_t kBlocks = 20;
  // Where damping begins in a line of both, on a terminal of kWide columns or more.
  static constexpr std::size_t kWide = 80, kDampingAt = 43;
  // Between two points that are kept: the shortest line, of a minute, has one in each block; an hour has 1200.
  static constexpr double kEvery_s = 3.0;

  // The dwell as it stands; one whose coefficients are not given, or stale, leaves a blank. now_s: never less than
  // before.
  void take(const DwellView& view, double now_s);
  // Dwells that have ended, oldest first: of each what was not taken before.
  void take_earlier(const std::vector<EarlierDwell>& dwells, double now_s);
  // Runs whose dwells could not be had, as the title names them.
  void take_lacking(std::vector<std::string> runs) { lacking_ = std::move(runs); }

  // A line for each element that has coefficients in `view`; below 80 columns damping stands on a line of its own.
  // Empty: there is none, or nothing has been seen before.
  [[nodiscard]] Section section(const DwellView& view, double now_s, std::size_t columns) const;

 private:
  struct Point {
    double from_s, t_s;                      // the values hold from … to
    std::vector<double> stiffness, damping;  // one per element; NaN: none
  };

  // Of element k (0 …) in each of the blocks, oldest first; NaN: none.
  [[nodiscard]] std::vector<double> in_blocks(std::vector<double> Point::*which, std::size_t element, double from_s,
                                              double until_s) const;

  std::deque<Point> points_;  // oldest first; kEvery_s apart, but for the newest, which is replaced until then
  std::vector<std::string> lacking_;
  std::string dwell_;  // names the newest with coefficients; empty: there was none
};

// The blocks of a line: `middle` stands between the fourth and the fifth of eight heights, middle ± reach at the edges.
[[nodiscard]] std::string sparkline(const std::vector<double>& values, double middle, double reach);

}  // namespace dwell::ctl
