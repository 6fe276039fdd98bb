// What a fit leaves unexplained. Two things show that a chain is wrong: the innovations of its channels, given the
// table, are correlated; and the table's own channels seem noisier than they are from reading to reading, since the fit
// then moves the table as the wrong chain would need it.
#pragma once

#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

struct Leftover {
  // Ljung-Box statistics beyond chance, times the variance of the noise as fitted over that from reading to reading;
  // of the table's channels the number of readings times the excess of that ratio. A statistic alone saturates where
  // residuals are large.
  double power = 0.0;
  double of_table = 0.0;  // the part of `power` by the table's channels
  double least_p = 1.0;   // of the least white channel of the chain

  // Whether a change of the model from `that` to this explains most of what was unexplained: `power` is at most half;
  // or the chain's channels are white now, and the table pays no more for it. Of white residuals `power` is chance
  // alone, and comparing it would reject every second right explanation of a weak fault.
  [[nodiscard]] bool explains_most_of(const Leftover& that) const;
};

// noise: per channel from reading to reading, SI, as local_noise(); size: per channel, SI, what is the least to compare
// with is rounding of it. Thread-safe; allocates.
[[nodiscard]] Leftover leftover(const MotionModel& model, const MotionData& data, const MotionUnknowns& unknowns,
                                const std::vector<double>& noise, const std::vector<double>& size);

}  // namespace dwell
