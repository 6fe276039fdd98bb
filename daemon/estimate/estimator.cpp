#include "daemon/estimate/estimator.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "core/intake/plain_run.hpp"

namespace dwell {
namespace {

// Records of the stream that are handed on together, at most: the longest run that is judged at once (PlainRun::kMost)
// of each of 64 channels. They take 128 KiB.
constexpr std::size_t kTogether = 64 * PlainRun::kMost;
constexpr std::size_t kSpare = 4096;  // room in the merger for ticks, actions and states beside the samples

// Of each source.
std::size_t merger_capacity(const std::vector<DeviceFeed>& devices) {
  std::size_t largest = 0;
  for (const DeviceFeed& device : devices) largest = std::max(largest, device.link->capacity());
  return kSpare + 2 * largest;
}

std::vector<Assembler::Source> sources_of(const Rig& rig, const std::vector<DeviceFeed>& devices) {
  std::vector<Assembler::Source> sources = Assembler::sources(rig);
  for (std::size_t i = 0; i < devices.size(); ++i) {
    sources[i].channels = devices[i].link->channels();
    sources[i].leads = devices[i].leads;
  }
  return sources;
}

}  // namespace

Estimator::Estimator(const Rig& rig, std::vector<DeviceFeed> devices, const EstimatorOptions& options, Log& log,
                     std::function<void()> wake, std::int64_t now_ns)
    : rig_(rig),
      gpio_(options.gpio),
      traces_(options.traces),
      assembler_(sources_of(rig, devices), options.hold_back_ns, merger_capacity(devices)),
      publisher_(std::move(wake)),
      cycle_(rig, options.runs, KeptDwells(options.kept_dwells, options.kept_bytes), options.long_work,
             [this](RunEvent event) { publisher_.tell(std::move(event)); }),
      next_publish_ns_(now_ns) {
  ready_.reserve(kTogether);
  devices_.reserve(devices.size());
  for (DeviceFeed& device : devices)
    devices_.emplace_back(devices_.size(), std::move(device), rig_, assembler_, options.hold_back_ns, log, now_ns);
}

void Estimator::turn(std::int64_t now_ns, std::int64_t utc_ns, std::uint64_t skipped) {
  cycle_.set_clocks(now_ns, utc_ns);
  skipped_ += skipped;
  assembler_.set_now(now_ns);
  for (DeviceIntake& device : devices_) device.offer_states();
  for (DeviceIntake& device : devices_) device.take(now_ns);
  for (DeviceIntake& device : devices_) device.find_faults(now_ns);
  take_edges(now_ns);
  // Actions and the tick last: a backlog in the rings must not look late beside them.
  take_actions(now_ns);
  for (DeviceIntake& device : devices_) device.account(now_ns);
  assembler_.tick(now_ns);
  while (gather(&Assembler::next)) hand_on();
  settle();
  if (now_ns >= next_publish_ns_) {
    const auto period_ns = static_cast<std::int64_t>(rig_.update_s * 1e9);
    next_publish_ns_ = std::max(next_publish_ns_ + period_ns, now_ns);
    for (DeviceIntake& device : devices_) device.tell_counted_faults(now_ns);
    publish(now_ns);
  }
}

void Estimator::finish(std::int64_t now_ns, std::int64_t utc_ns) {
  turn(now_ns, utc_ns);
  for (DeviceIntake& device : devices_) device.stop(now_ns);
  release();
  for (DeviceIntake& device : devices_) {
    device.offer_states();
    device.account(now_ns);
  }
  release();
  cycle_.finish(now_ns);
  settle();
  publish(now_ns);
  for (DeviceIntake& device : devices_) device.tell_end();
}

// The edges' source is heard of although nothing happens there, so that the merger need not guess how long to wait.
void Estimator::take_edges(std::int64_t now_ns) {
  if (gpio_ == nullptr) return;
  const std::int64_t seen_to_ns = gpio_->seen_to_ns();
  Record edge;
  while (gpio_->pop(edge)) {
    // The interlock is never too late to matter, nor may it wait; a pulse with a wrong instant is worse than none.
    const bool urgent = edge.channel == static_cast<std::uint16_t>(Line::interlock);
    if (urgent) edge.t_ns = std::min(edge.t_ns, now_ns);
    if (urgent ? !assembler_.urgent_edge(edge) : assembler_.edge(edge) != Merger::Admission::queued) gpio_->late();
  }
  assembler_.edges_seen_to(seen_to_ns);
}

void Estimator::take_actions(std::int64_t now_ns) {
  while (actions_.read_available() > 0) {
    Record record = actions_.front();
    record.t_ns = now_ns;
    if (!assembler_.action(record)) return;  // no room: at the next turn
    actions_.pop();
  }
}

bool Estimator::gather(bool (Assembler::*next)(Record&) noexcept) {
  ready_.clear();
  for (Record record; ready_.size() < kTogether && (assembler_.*next)(record);) ready_.push_back(record);
  return !ready_.empty();
}

void Estimator::hand_on() {
  if (traces_ != nullptr)
    for (const Record& record : ready_) traces_->take(record);
  for (std::span<const Record> left(ready_); !left.empty();) {
    std::size_t taken = cycle_.take_samples(left);
    if (taken == 0) cycle_.take(left[taken++]);
    left = left.subspan(taken);
  }
}

// Everything, without waiting for anybody.
void Estimator::release() {
  while (gather(&Assembler::flush)) hand_on();
}

void Estimator::settle() {
  for (DeviceIntake& device : devices_) device.settle(cycle_.accounts());
}

void Estimator::publish(std::int64_t now_ns) {
  Snapshot& to = publisher_.next();
  to.t_ns = now_ns;
  cycle_.show(to);
  to.skipped_turns = skipped_;
  to.channels.resize(rig_.channels.size());
  to.devices.resize(devices_.size());
  for (DeviceIntake& device : devices_) device.show(rig_, cycle_.pipeline(), cycle_.accounts(), now_ns, to);
  publisher_.publish();
}

}  // namespace dwell
