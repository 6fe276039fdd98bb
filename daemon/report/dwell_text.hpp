// A dwell as an operator reads it: what state it is in and why, the frequency, a table of channels, a table of
// coefficients with the largest source of each one's uncertainty, the warnings. Intervals are 95 %.
#pragma once

#include <string>
#include <vector>

#include "daemon/report/dwell_view.hpp"

namespace dwell {

// What a simulated rig really is; one value per element, SI.
struct Truth {
  std::vector<double> stiffness;
  std::vector<double> damping;
};

// One line: "dwell 3 · measuring, 24.6 s of data".
[[nodiscard]] std::string headline(const DwellView& view);

// Lines on settling (the verdict, what it rests on, the time left or taken) and on the frequency.
[[nodiscard]] std::string verdict_text(const DwellView& view);

// Phases are those relative to the first channel that has one, which the column's title names.
[[nodiscard]] std::string phasor_table(const DwellView& view);

// truth: shown beside the measured values, with the deviation in standard uncertainties; nullptr: largest sources of
// uncertainty instead. Below the table the reasons of the elements that are not identifiable.
[[nodiscard]] std::string element_table(const DwellView& view, const Truth* truth);

// All of it, one screen.
[[nodiscard]] std::string dwell_text(const DwellView& view, const Truth* truth = nullptr);

}  // namespace dwell
