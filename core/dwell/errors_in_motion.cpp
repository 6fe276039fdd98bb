#include "core/dwell/errors_in_motion.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/chance.hpp"
#include "core/base/instants.hpp"

namespace dwell {
namespace {

// Readings looked at, of all channels and of one. Halved, errors must be a fifth larger beside the noise to be found;
// doubled, a look takes twice as long.
constexpr std::size_t kMostLookedAt = 65'536, kMostOfChannel = 4096;
// Periods of data before the first look: with fewer, most channels have too few readings.
constexpr double kFirstLook = 12.0;
// Channels whose instants are compared with those of all others, at a look. Halved, the fifth and later groups of
// stamps count as errors of each channel alone. Doubled, this comparison takes twice as long.
constexpr int kMostLeads = 8;

// The variance of instants beyond what the budget has, s².
double beyond_known(const MovingChannel& seen) noexcept {
  return seen.errors.instants_s * seen.errors.instants_s - seen.known_s * seen.known_s;
}

}  // namespace

ErrorsInMotion::ErrorsInMotion(int channels)
    : most_(std::min(kMostOfChannel, kMostLookedAt / static_cast<std::size_t>(std::max(channels, 1)))),
      readings_(most_ * static_cast<std::size_t>(channels)),
      counts_(static_cast<std::size_t>(channels)),
      passed_(static_cast<std::size_t>(channels)),
      seen_(static_cast<std::size_t>(channels)),
      found_(static_cast<std::size_t>(channels)),
      grouped_(static_cast<std::size_t>(channels)),
      next_(seen_.size()) {}

void ErrorsInMotion::begin(std::int64_t settled_ns) noexcept {
  settled_ns_ = looked_ns_ = settled_ns;
  next_ = seen_.size();
  std::fill(found_.begin(), found_.end(), Found{});
}

bool ErrorsInMotion::due(std::int64_t now_ns, double period_s) const noexcept {
  return next_ < seen_.size() ||
         now_ns - looked_ns_ >= std::max(looked_ns_ - settled_ns_, to_ns(kFirstLook * period_s));
}

void ErrorsInMotion::join(std::size_t lead, std::size_t channel, double shared_s) noexcept {
  const int group = found_[lead].with >= 0 ? found_[lead].with : static_cast<int>(lead);
  const int before = found_[channel].with;
  found_[lead].with = found_[channel].with = group;
  for (Found& found : found_) {
    if (found.with != group && (before < 0 || found.with != before)) continue;
    found.with = group;
    shared_s = std::max(shared_s, found.shared_s);
  }
  for (Found& found : found_)
    if (found.with == group) found.shared_s = shared_s;
  // What it has shown alone is explained now.
  found_[lead].own_s = found_[channel].own_s = 0.0;
}

void ErrorsInMotion::keep() noexcept {
  int leads = 0;
  std::fill(grouped_.begin(), grouped_.end(), false);
  for (std::size_t c = 0; c < seen_.size(); ++c) {
    const MovingChannel& seen = seen_[c];
    found_[c].part = std::max(found_[c].part, seen.errors.part);
    if (!(seen.errors.instants_s > 0) || grouped_[c]) continue;
    const double own_s2 = beyond_known(seen);
    bool alone = true;
    for (std::size_t other = 0; leads < kMostLeads && other < seen_.size(); ++other) {
      if (other == c || grouped_[other] || !share_instants(seen, seen_[other], omega_)) continue;
      grouped_[other] = true;
      alone = false;
      join(c, other, std::sqrt(std::max({0.0, own_s2, beyond_known(seen_[other])})));
    }
    ++leads;
    if (alone && own_s2 > sigmas::kSure * seen.errors.instants_u2)
      found_[c].own_s = std::max(found_[c].own_s, std::sqrt(own_s2));
  }
}

}  // namespace dwell
