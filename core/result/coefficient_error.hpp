// Effects of one standard deviation of an error source: on the coefficients of a dwell, and on masses, clock and
// readings. Code that derives a number from the coefficients applies all of these changes together, with their signs;
// this keeps the correlations. Plain data.
#pragma once

#include <cstddef>
#include <vector>

namespace dwell {

// Effect on one channel's reading of any motion exp(st).
struct ReadingError {
  std::ptrdiff_t channel;                      // index into Rig::channels
  double relative = 0.0, late_s = 0.0;         // the reading is too small by this part; it is later than stated
  double lowpass_hz = 0.0, highpass_hz = 0.0;  // the corner is higher than stated
};

struct CoefficientError {
  std::vector<double> on_coefficients;  // changes of c_1, r_1, c_2 … of all elements; 0 where not determined
  int mass = 0;                         // k, if the source is the uncertainty of mass k; else 0
  double mass_u = 0.0;                  // change of that mass, kg (kg·m²)
  double clock_u = 0.0;                 // relative change of the rate of the host's clock, which all instants share
  std::vector<ReadingError> readings;   // empty unless a scale, delay, filter, turnaround or refreshed register
};

}  // namespace dwell
