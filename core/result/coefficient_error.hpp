// What one standard deviation of a source of error does to the coefficients of a dwell, and to what else it touches:
// whoever derives something from the coefficients keeps the correlations by moving all of it at once. Plain data.
#pragma once

#include <cstddef>
#include <vector>

namespace dwell {

// What one standard deviation of a source of error makes of a channel's reading of any motion exp(st).
struct ReadingError {
  std::ptrdiff_t channel;
  double relative = 0.0, late_s = 0.0;         // too small by that part; too late
  double lowpass_hz = 0.0, highpass_hz = 0.0;  // corners higher than stated
};

struct CoefficientError {
  std::vector<double> on_coefficients;  // to c_1, r_1, c_2 … of all elements; 0 where not determined
  int mass = 0;                         // k of the mass that it is the uncertainty of; 0: of none
  double mass_u = 0.0;                  // that uncertainty, kg (kg·m²)
  double clock_u = 0.0;                 // of the rate of the host's clock, which all times share; relative
  std::vector<ReadingError> readings;   // of scales, delays, filters, turnarounds and refreshed registers
};

}  // namespace dwell
