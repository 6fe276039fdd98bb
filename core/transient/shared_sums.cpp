#include "core/transient/shared_sums.hpp"

#include <cassert>

namespace dwell {

using Eigen::Index;

SharedSums::SharedSums(int channels, Index most)
    : channels_(static_cast<std::size_t>(channels), PerChannel{ReadingSums{Eigen::VectorXd(most)}}),
      groups_(static_cast<std::size_t>(channels), Group{NormalMatrix(most)}) {
  clear();
}

void SharedSums::clear() noexcept {
  for (PerChannel& channel : channels_) {
    ReadingSums& readings = channel.readings;
    readings.moments.setZero();
    readings.squares = readings.samples = readings.reference = 0.0;
    channel.group = channel.scan = 0;
  }
  Group& all = groups_.front();
  all.normal.clear();
  all.members = all.seen = static_cast<int>(channels_.size());
  all.scan = 0;
  used_ = 1;
}

double SharedSums::add(int channel, std::uint64_t scan, const Eigen::VectorXd& x, Index all, double value) noexcept {
  PerChannel& own = channels_[static_cast<std::size_t>(channel)];
  assert(own.scan != scan);
  const auto products = static_cast<double>(all);
  double work = products;
  if (groups_[own.group].scan != scan) {
    part(own.group, all);
    Group& group = groups_[own.group];  // part() may have moved the channel
    group.normal.add(x, all);
    group.scan = scan;
    group.seen = 0;
    work += 0.5 * products * products;
  }
  own.scan = scan;
  ++groups_[own.group].seen;
  ReadingSums& readings = own.readings;
  if (readings.samples == 0) readings.reference = value;
  const double s = value - readings.reference;
  readings.moments.head(all) += s * x.head(all);
  readings.squares += s * s;
  readings.samples += 1.0;
  return work;
}

void SharedSums::complete(int channel, Index all) noexcept {
  const PerChannel& own = at(channel);
  part(own.group, all);
  groups_[own.group].normal.complete(all);
}

// Moves the channels that missed the group's newest scan into a new group.
void SharedSums::part(std::size_t group, Index all) noexcept {
  Group& from = groups_[group];
  if (from.seen == from.members) return;
  Group& to = groups_[used_];
  to.normal.take_all_but_newest(from.normal, all);
  to.members = 0;
  to.scan = 0;
  for (PerChannel& channel : channels_)
    if (channel.group == group && channel.scan != from.scan) {
      channel.group = used_;
      ++to.members;
    }
  to.seen = to.members;
  from.members = from.seen;
  ++used_;
}

}  // namespace dwell
