#include "daemon/estimate/stream_accounts.hpp"

namespace dwell {
namespace {

std::uint64_t own_gaps(const RunPipeline& pipeline, std::size_t channel) noexcept {
  return pipeline.measurement().pipeline().channel(static_cast<int>(channel)).gaps;
}

}  // namespace

// The difference may be below zero; unsigned numbers wrap, and the sums come out right.
void StreamAccounts::follow(const RunPipeline& shown) noexcept {
  for (std::size_t c = 0; c < carried_.size(); ++c) {
    const std::uint64_t rejected = fate(c).rejected, gaps = this->gaps(c);
    carried_[c].rejected = rejected - shown.measurement().fate(c).rejected;
    carried_[c].gaps = gaps - own_gaps(shown, c);
  }
  shown_ = &shown;
}

Measurement::Fate StreamAccounts::fate(std::size_t channel) const noexcept {
  if (shown_ == nullptr) return {};
  const Measurement::Fate own = shown_->measurement().fate(channel);
  const std::uint64_t taken = shown_->samples_before(channel) + own.used + own.rejected;
  const std::uint64_t rejected = carried_[channel].rejected + own.rejected;
  return {taken - rejected, rejected};
}

std::uint64_t StreamAccounts::gaps(std::size_t channel) const noexcept {
  return shown_ == nullptr ? 0 : carried_[channel].gaps + own_gaps(*shown_, channel);
}

}  // namespace dwell
