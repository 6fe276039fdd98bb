#include "daemon/ctl/verifications_again.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

namespace dwell::ctl {
namespace {

// The dwell as it stands after the record taken last, or the one of that index which ended with it.
std::optional<Dwell> dwell_of(const VerifiedDwell& of, const Replay& replay) {
  if (!of.ended) return replay.current();
  for (const Dwell& dwell : replay.ended())
    if (dwell.index == of.dwell.index) return dwell;
  return std::nullopt;
}

}  // namespace

VerificationsAgain::VerificationsAgain(std::vector<PublishedVerification> published) : newest_(published) {
  for (PublishedVerification& one : published) by_position_.push_back({std::move(one), nullptr});
  std::stable_sort(by_position_.begin(), by_position_.end(), [](const Awaited& a, const Awaited& b) {
    return a.published.of.position < b.published.of.position;
  });
  by_last_.resize(by_position_.size());
  std::iota(by_last_.begin(), by_last_.end(), std::size_t{0});
  std::stable_sort(by_last_.begin(), by_last_.end(), [this](std::size_t a, std::size_t b) {
    return by_position_[a].published.of.last < by_position_[b].published.of.last;
  });
}

std::uint64_t VerificationsAgain::free_until(const Replay& replay) const noexcept {
  if (next_ == by_position_.size()) return UINT64_MAX;
  const std::uint64_t position = by_position_[next_].published.of.position;
  return position > replay.position() ? position - replay.position() - 1 : 0;
}

void VerificationsAgain::take(const Replay& replay, std::int64_t origin_ns, const Make& make) {
  if (next_ == by_position_.size()) return;
  if (const SampleHistory* const history = replay.readings()) gather(*history, origin_ns);
  for (; next_ < by_position_.size() && by_position_[next_].published.of.position <= replay.position(); ++next_) {
    Awaited& awaited = by_position_[next_];
    if (awaited.evidence) --kept_;
    VerificationJob job{std::exchange(awaited.evidence, nullptr), awaited.published.of, nullptr};
    auto dwell = awaited.published.of.position == replay.position() ? dwell_of(job.result, replay) : std::nullopt;
    if (!dwell || !job.evidence) {
      left_.push_back(std::move(awaited.published));
      continue;
    }
    job.result.dwell = std::move(*dwell);
    state_stretch(*job.evidence, job.result);
    make(std::move(awaited.published.stored), std::move(job));
  }
}

void VerificationsAgain::gather(const SampleHistory& history, std::int64_t origin_ns) {
  keep_evidence();
  for (gathered_ = std::max(gathered_, history.begin()); gathered_ < history.end();) {
    const SampleHistory::Sample& sample = history[gathered_];
    newest_.push({sample.t_ns - origin_ns, sample.value, sample.channel});
    ++gathered_;
    keep_evidence();
  }
}

// Of all that end with the reading gathered last.
void VerificationsAgain::keep_evidence() {
  Evidence newest;
  std::size_t of = 0;  // readings asked for, of `newest`
  for (; next_evidence_ < by_last_.size(); ++next_evidence_) {
    Awaited& awaited = by_position_[by_last_[next_evidence_]];
    if (awaited.published.of.last > gathered_) return;
    if (awaited.published.of.last < gathered_ || kept_ == kMostKept) continue;
    if (const std::size_t given = awaited.published.of.given; !newest || of != given) {
      newest = std::make_shared<const std::vector<HoldRecord::Reading>>(newest_.newest(given));
      of = given;
    }
    awaited.evidence = newest;
    ++kept_;
  }
}

std::vector<PublishedVerification> VerificationsAgain::left() const {
  std::vector<PublishedVerification> all = left_;
  for (std::size_t i = next_; i < by_position_.size(); ++i) all.push_back(by_position_[i].published);
  return all;
}

}  // namespace dwell::ctl
