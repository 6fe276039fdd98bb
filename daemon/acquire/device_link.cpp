#include "daemon/acquire/device_link.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/base/printable.hpp"
#include "daemon/clock.hpp"

namespace dwell {
namespace {

constexpr std::size_t kEvents = 64;

DeviceLink& link_of(void* context) noexcept { return *static_cast<DeviceLink*>(context); }

Fault known_fault(int fault) noexcept {
  return fault >= 0 && fault < kFaultCount ? static_cast<Fault>(fault) : Fault::bad_frame;
}

std::uint16_t largest(const std::vector<std::uint16_t>& channels) {
  return channels.empty() ? std::uint16_t{0} : *std::max_element(channels.begin(), channels.end());
}

}  // namespace

DeviceLink::DeviceLink(std::string name, std::vector<std::uint16_t> channels, std::size_t capacity, LogLine log)
    : name_(std::move(name)),
      channels_(std::move(channels)),
      capacity_(capacity),
      log_(std::move(log)),
      positions_(std::size_t{largest(channels_)} + 1, -1),
      own_(std::make_unique<Own[]>(channels_.size())),
      samples_(capacity),
      events_(kEvents),
      last_turn_ns_(raw_now_ns()) {
  for (std::size_t i = 0; i < channels_.size(); ++i) positions_[channels_[i]] = static_cast<std::int16_t>(i);
}

dwell_host DeviceLink::host() noexcept {
  dwell_host host{};
  host.size = sizeof(dwell_host);
  host.context = this;
  host.push = [](void* context, const dwell_sample* samples, std::size_t count) noexcept -> std::int32_t {
    return link_of(context).push(samples, count) ? 1 : 0;
  };
  host.state = [](void* context, std::int32_t channel, dwell_fault fault, const char* reason) noexcept {
    link_of(context).state(channel, fault, reason);
  };
  host.count = [](void* context, dwell_fault fault, std::uint64_t occurrences) noexcept {
    link_of(context).count(fault, occurrences);
  };
  host.log = [](void* context, dwell_level level, const char* message) noexcept {
    // What the log throws must not reach a driver, which may be C.
    try {
      DeviceLink& link = link_of(context);
      if (link.log_ && message != nullptr && !link.abandoned_.load(std::memory_order_acquire))
        link.log_(level, message);
    } catch (...) {  // NOLINT(bugprone-empty-catch): a line of log is lost, nothing else
    }
  };
  host.turn = [](void* context) noexcept { link_of(context).turn(raw_now_ns()); };
  host.room = [](void* context) noexcept -> std::size_t { return link_of(context).room(); };
  return host;
}

bool DeviceLink::push(const dwell_sample* samples, std::size_t count) noexcept {
  if (abandoned_.load(std::memory_order_acquire)) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (position(samples[i].channel) < 0) {
      foreign_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
  }
  for (std::size_t i = 0; i < count; ++i) counters(position(samples[i].channel)).receive();
  if (samples_.write_available() < count) {
    mark_gaps(samples, count);
    return false;
  }
  // Counted before it enters, so that the consumer never seems to have taken more than there was.
  entered_.store(entered_.load(std::memory_order_relaxed) + count, std::memory_order_release);
  for (std::size_t i = 0; i < count; ++i) {
    const dwell_sample& from = samples[i];
    bool& gap = own_[static_cast<std::size_t>(position(from.channel))].gap;
    const auto flags = static_cast<std::uint8_t>((from.flags & (kGap | kStampReplaced)) | (gap ? kGap : 0));
    gap = false;
    samples_.push(Record{.t_ns = from.t_ns,
                         .value = from.raw,
                         .t_half_ns = from.t_half_ns,
                         .channel = from.channel,
                         .kind = Kind::sample,
                         .flags = flags});
  }
  return true;
}

void DeviceLink::mark_gaps(const dwell_sample* samples, std::size_t count) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    Own& own = own_[static_cast<std::size_t>(position(samples[i].channel))];
    own.counters.refuse();
    own.gap = true;
  }
}

void DeviceLink::state(std::int32_t channel, dwell_fault fault, const char* reason) noexcept {
  const int at = channel < 0 ? -1 : position(static_cast<std::size_t>(channel));
  if (channel >= 0 && at < 0) {
    foreign_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  offer_waiting();
  StateEvent event;
  event.t_ns = raw_now_ns();
  event.channel = channel < 0 ? -1 : channel;
  event.fault = known_fault(fault);
  if (reason != nullptr) {
    std::string_view rest(reason);
    for (std::size_t i = 0; i + 1 < StateEvent::kReasonSize && !rest.empty(); ++i) {
      const std::size_t control = control_bytes(rest);
      event.reason[i] = control > 0 ? ' ' : rest.front();
      rest.remove_prefix(std::max(control, std::size_t{1}));
    }
  }
  if (!any_waiting_ && events_.push(event)) return;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (at >= 0 && static_cast<std::size_t>(at) != i) continue;
    own_[i].waiting = event;
    own_[i].waiting->channel = channels_[i];
    any_waiting_ = true;
  }
}

void DeviceLink::offer_waiting() noexcept {
  if (!any_waiting_) return;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    std::optional<StateEvent>& waiting = own_[i].waiting;
    if (!waiting) continue;
    if (!events_.push(*waiting)) return;
    waiting.reset();
  }
  any_waiting_ = false;
}

void DeviceLink::count(dwell_fault fault, std::uint64_t occurrences) noexcept {
  faults_[static_cast<std::size_t>(known_fault(fault))].fetch_add(occurrences, std::memory_order_relaxed);
}

void DeviceLink::turn(std::int64_t now_ns) noexcept {
  offer_waiting();
  last_turn_ns_.store(now_ns, std::memory_order_relaxed);
}

std::size_t DeviceLink::pop_samples(Record* out, std::size_t room) noexcept {
  const std::size_t taken = samples_.pop(out, room);
  if (taken > 0) left_.store(left_.load(std::memory_order_relaxed) + taken, std::memory_order_release);
  return taken;
}

std::uint64_t DeviceLink::faults(Fault fault) const noexcept {
  return faults_[static_cast<std::size_t>(fault)].load(std::memory_order_relaxed);
}

}  // namespace dwell
