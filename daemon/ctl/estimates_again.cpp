#include "daemon/ctl/estimates_again.hpp"

#include <algorithm>
#include <utility>

namespace dwell::ctl {

EstimatesAgain::EstimatesAgain(const Rig& rig, std::vector<PublishedEstimate> published)
    : published_(std::move(published)), newest_(published_) {
  for (const Channel& channel : rig.channels) counts_.push_back(channel.measures != Quantity::auxiliary);
  std::stable_sort(published_.begin(), published_.end(),
                   [](const PublishedEstimate& a, const PublishedEstimate& b) { return a.of.last < b.of.last; });
}

void EstimatesAgain::take(const Record& record, std::int64_t t_ns, std::uint64_t position, const Make& make) {
  if (next_ == published_.size()) return;
  if (record.kind != Kind::sample || record.channel >= counts_.size() || !counts_[record.channel]) return;
  newest_.push({t_ns, record.value, record.channel, record.t_half_ns});
  for (; next_ < published_.size() && published_[next_].of.last <= position; ++next_) {
    PublishedEstimate& published = published_[next_];
    if (published.of.last < position) {  // what it names as its last reading is none
      left_.push_back(std::move(published));
      continue;
    }
    TransientJob job;
    job.result = std::move(published.of);
    job.readings = newest_.newest(job.result.given);
    state_stretch(job.readings, job.result);
    make(std::move(published.stored), std::move(job));
  }
}

std::vector<PublishedEstimate> EstimatesAgain::left() const {
  std::vector<PublishedEstimate> all = left_;
  all.insert(all.end(), published_.begin() + static_cast<std::ptrdiff_t>(next_), published_.end());
  return all;
}

}  // namespace dwell::ctl
