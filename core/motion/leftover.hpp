// What a fit leaves unexplained: how far the innovations of the chain's channels are from white. The table's own
// channels are left out, for a poor model of its motion does not convict the chain.
#pragma once

#include <vector>

#include "core/motion/likelihood.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct Leftover {
  double statistic = 0.0;  // Ljung-Box beyond what chance gives, over all these channels
  double least_p = 1.0;    // of the least white channel

  // Whether this is white, or by far whiter than that: most of what was unexplained is explained.
  [[nodiscard]] bool explains_most_of(const Leftover& that) const;
};

// Of the innovations given the table (core/motion/given_table.hpp). Thread-safe; allocates.
[[nodiscard]] Leftover leftover(const MotionModel& model, const MotionData& data, const MotionUnknowns& unknowns);

}  // namespace dwell
