#include "core/motion/leftover.hpp"

#include <algorithm>

#include "core/motion/whiteness.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

// Most: more than a half. A term that leaves more than that is a part of the story at best.
constexpr double kMost = 0.5;

}  // namespace

bool Leftover::explains_most_of(const Leftover& that) const {
  return least_p >= kNotWhite || statistic <= kMost * that.statistic;
}

Leftover leftover(const Rig& rig, const Pass& pass) {
  Leftover out;
  for (std::size_t c = 0; c < pass.innovations.size(); ++c) {
    const Channel& channel = rig.channels[c];
    if (channel.measures == Quantity::auxiliary || shows_drive(channel)) continue;
    const double statistic = ljung_box(pass.innovations[c]);
    if (!(statistic >= 0.0)) continue;
    out.statistic += std::max(0.0, statistic - kWhitenessLags);
    out.least_p = std::min(out.least_p, whiteness_p(statistic));
  }
  return out;
}

}  // namespace dwell
