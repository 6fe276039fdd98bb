#include "core/dwell/errors_in_motion.hpp"

#include <algorithm>
#include <utility>

#include "core/base/instants.hpp"

namespace dwell {
namespace {

// Readings looked at. Halved, errors must be a third larger beside the noise; doubled, a look takes 5 ms.
constexpr std::size_t kMostLookedAt = 65'536, kMostOfChannel = 4096;
// Periods of data before the first look: with fewer, most channels have fewer pairs than it takes.
constexpr double kFirstLook = 12.0;

// Channels whose instants are compared with those of all others, at a look. Halved, more channels are taken for uneven
// each by itself where scans have several stamps; doubled, a look takes 5 ms.
constexpr int kMostLeads = 8;

}  // namespace

ErrorsInMotion::ErrorsInMotion(int channels)
    : most_(std::min(kMostOfChannel, kMostLookedAt / static_cast<std::size_t>(std::max(channels, 1)))),
      readings_(most_ * static_cast<std::size_t>(channels)),
      counts_(static_cast<std::size_t>(channels)),
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

void ErrorsInMotion::begin_look(const SampleHistory& history, std::int64_t until_ns) noexcept {
  looked_ns_ = until_ns;
  next_ = 0;
  std::fill(counts_.begin(), counts_.end(), std::size_t{0});
  const std::uint64_t end = history.first_at(until_ns);
  const std::uint64_t first = std::max(history.begin(), history.first_at(settled_ns_));
  const std::uint64_t from = std::max(first, end - std::min<std::uint64_t>(end, readings_.size()));
  if (from >= end) return;
  for (std::uint64_t number = from; number < end; ++number) {
    const SampleHistory::Sample& sample = history[number];
    const auto c = static_cast<std::size_t>(sample.channel);
    if (counts_[c] < most_) readings_[c * most_ + counts_[c]++] = {.t_ns = sample.t_ns, .value = sample.value};
  }
  about_ns_ = history[from].t_ns + (until_ns - history[from].t_ns) / 2;
}

void ErrorsInMotion::keep() noexcept {
  int leads = 0;
  std::fill(grouped_.begin(), grouped_.end(), false);
  for (std::size_t c = 0; c < seen_.size(); ++c) {
    const MovingErrors& errors = seen_[c].errors;
    Found& found = found_[c];
    found.part = std::max(found.part, errors.part);
    if (!(errors.instants_s > 0) || grouped_[c]) continue;
    found.instants_s = std::max(found.instants_s, errors.instants_s);
    if (++leads > kMostLeads) continue;
    for (std::size_t other = 0; other < seen_.size(); ++other) {
      if (other == c || grouped_[other] || !share_instants(seen_[c], seen_[other], omega_)) continue;
      grouped_[other] = true;
      found_[other].with = found.with = static_cast<int>(c);
      found.instants_s = std::max(found.instants_s, std::exchange(found_[other].instants_s, 0.0));
    }
  }
}

}  // namespace dwell
