#include "daemon/ctl/estimates_again.hpp"

#include <algorithm>
#include <utility>

#include "core/base/instants.hpp"

namespace dwell::ctl {
namespace {

std::size_t largest(const std::vector<PublishedEstimate>& published) {
  std::size_t most = 1;
  for (const PublishedEstimate& one : published) most = std::max(most, one.of.given);
  return most;
}

}  // namespace

EstimatesAgain::EstimatesAgain(const Rig& rig, std::vector<PublishedEstimate> published)
    : published_(std::move(published)), newest_(largest(published_)) {
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
    job.readings = newest_.readings();
    const std::size_t given = std::min(job.result.given, job.readings.size());
    job.readings.erase(job.readings.begin(), job.readings.end() - static_cast<std::ptrdiff_t>(given));
    job.result.given = given;
    if (given > 0) {
      job.result.from_s = to_s(job.readings.front().t_ns);
      job.result.until_s = to_s(job.readings.back().t_ns);
    }
    make(std::move(published.stored), std::move(job));
  }
}

std::vector<PublishedEstimate> EstimatesAgain::left() const {
  std::vector<PublishedEstimate> all = left_;
  all.insert(all.end(), published_.begin() + static_cast<std::ptrdiff_t>(next_), published_.end());
  return all;
}

}  // namespace dwell::ctl
