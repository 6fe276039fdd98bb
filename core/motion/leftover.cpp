#include "core/motion/leftover.hpp"

#include <algorithm>

#include "core/motion/given_table.hpp"
#include "core/motion/whiteness.hpp"

namespace dwell {
namespace {

// Most: more than a half. A term that leaves more than that is a part of the story at best.
constexpr double kMost = 0.5;

}  // namespace

bool Leftover::explains_most_of(const Leftover& that) const {
  return least_p >= kNotWhite || statistic <= kMost * that.statistic;
}

Leftover leftover(const MotionModel& model, const MotionData& data, const MotionUnknowns& unknowns) {
  Leftover out;
  for (const std::vector<MotionInnovation>& innovations : innovations_given_table(model, data, unknowns)) {
    const Whiteness whiteness = whiteness_of(innovations);
    if (!(whiteness.ljung_box >= 0.0)) continue;
    out.statistic += std::max(0.0, whiteness.ljung_box - kWhitenessLags);
    out.least_p = std::min(out.least_p, whiteness.p);
  }
  return out;
}

}  // namespace dwell
