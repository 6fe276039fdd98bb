// Pictures of the report as inline SVG: the chain, a channel over time, phasors. Texts are escaped. Sizes are in CSS
// pixels (96 per inch); A4 has 640 between its margins.
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "core/rig/rig.hpp"
#include "daemon/handon/trace.hpp"

namespace dwell::handon {

// "0.1", "2.5e+06": a number for an axis.
[[nodiscard]] std::string axis_number(double value);
// Round values (1, 2 or 5 times a power of ten apart) that divide low … high into at most `most` parts.
[[nodiscard]] std::vector<double> ticks(double low, double high, int most);

// A shaded stretch of time: the data of a dwell that count.
struct Shaded {
  double from_s, to_s;
  std::string label;
};

// Minimum and maximum of each part of the time as a filled curve, with axes.
[[nodiscard]] std::string trace_picture(const Trace& trace, const std::string& name, const std::string& unit,
                                        double begin_s, double end_s, const std::vector<Shaded>& shaded);

struct Arrow {
  std::complex<double> value;
  int number = 0;     // beside its tip
  std::size_t group;  // arrows of a group share a unit and a scale
};

// Arrows from a common centre; the longest of each group reaches the outer circle. Angles grow counterclockwise, 0 to
// the right.
[[nodiscard]] std::string phasor_picture(const std::vector<Arrow>& arrows);

// Table, elements and masses in a row, and the ground where the chain is clamped.
[[nodiscard]] std::string chain_picture(const Rig& rig);

}  // namespace dwell::handon
