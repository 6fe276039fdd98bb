// What a fit leaves unexplained. Two things show that a chain is wrong. The innovations of its channels, given the
// table, are correlated. And the fit moves the table as the wrong chain would need it, so the table's own channels seem
// noisier than they are from reading to reading.
#pragma once

#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// Residuals above this part of a channel's rms, beyond the noise from reading to reading: the elements are not linear,
// and a coefficient would be an average over amplitudes. Twice the accuracy that a model needs by default.
inline constexpr double kNotLinear = 0.1;
// … and above this many times that noise, which is known to 10 %.
inline constexpr double kMoreThanNoise = 1.5;

struct Leftover {
  // Sum over the channels. With r = (fitted noise / noise from reading to reading)², a channel of the chain adds its
  // Ljung-Box statistic beyond chance times r; the factor is there because the statistic saturates where residuals are
  // large. A channel of the table adds its number of readings times the excess of r.
  double power = 0.0;
  double of_table = 0.0;  // the part of `power` by the table's channels
  double least_p = 1.0;   // of the least white channel of the chain

  // Whether this model explains most of what `before`, a simpler model, left unexplained. True if `power` is at most
  // half; or if the chain's channels are white now and `of_table` is at most the former `power`. The second rule is for
  // weak faults: the `power` of white residuals is chance, and a comparison would reject every second right model.
  [[nodiscard]] bool explains_most_of(const Leftover& before) const;
};

// Per channel, SI: `noise` from reading to reading, as local_noise() gives it; `size` of the readings, whose rounding
// is the least noise that is believed. Thread-safe; allocates.
[[nodiscard]] Leftover leftover(const MotionModel& model, const MotionData& data, const MotionUnknowns& unknowns,
                                const std::vector<double>& noise, const std::vector<double>& size);

}  // namespace dwell
