#include "core/stream/scan_clocks.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace dwell {

ScanClocks::ScanClocks(Clock clock, const std::vector<std::uint16_t>& channels, double rate_hz) : kind_(clock) {
  const auto largest = std::max_element(channels.begin(), channels.end());
  places_.resize(largest == channels.end() ? 0 : std::size_t{*largest} + 1);
  streams_.assign(channels.size(), Stream{DeviceClock(rate_hz), {}, 0, {}});
  // As many scans as a clock holds, the one coming in, and one node that keeps the list from emptying.
  nodes_.resize(kind_ == Clock::device ? channels.size() * (HeldArrivals::kCapacity + 1) + 1 : 2);
  for (std::size_t i = 0; i < nodes_.size(); ++i) append(free_, static_cast<int>(i));
}

void ScanClocks::push(const Record& sample) noexcept {
  assert(sample.channel < places_.size());
  Place& place = places_[sample.channel];
  if (scan_stream_ < 0 || sample.t_ns != scan_ns_ || place.scan == scan_) {
    ++scan_;
    scan_ns_ = sample.t_ns;
    if (place.stream < 0) place.stream = static_cast<int>(streams_used_++);
    scan_stream_ = place.stream;
    streams_[static_cast<std::size_t>(scan_stream_)].clock.arrive(sample.t_ns);
  } else if (place.stream < 0) {
    place.stream = scan_stream_;
  } else if (place.stream != scan_stream_) {
    unite(place.stream, scan_stream_);
  }
  place.scan = scan_;
  Stream& stream = streams_[static_cast<std::size_t>(scan_stream_)];
  // Channels regrouped into other scans: more scans than the clocks hold.
  if (free_.first == free_.last) flush();
  const int node = take_first(free_);
  assert(node >= 0);
  nodes_[static_cast<std::size_t>(node)].record = sample;
  nodes_[static_cast<std::size_t>(node)].record.stamped_ns = sample.t_ns;
  nodes_[static_cast<std::size_t>(node)].scan = scan_;
  if (kind_ == Clock::host) {
    for (DeviceClock::Instant instant; stream.clock.next(instant);) {
    }
    append(out_, node);
    return;
  }
  if (stream.decided == scan_) {
    give_out(node, stream.instant);
    return;
  }
  append(stream.held, node);
  settle(stream);
}

// Two streams turn out to arrive together: they are one stream from the next scan on.
void ScanClocks::unite(int a, int b) noexcept {
  const int kept = std::min(a, b), given_up = std::max(a, b);
  for (Place& place : places_)
    if (place.stream == given_up) place.stream = kept;
  Stream& stream = streams_[static_cast<std::size_t>(given_up)];
  stream.clock.decide_all();
  settle(stream);
}

void ScanClocks::wait(std::int64_t now_ns) noexcept {
  for (std::size_t i = 0; i < streams_used_; ++i) {
    streams_[i].clock.wait(now_ns);
    settle(streams_[i]);
  }
}

void ScanClocks::flush() noexcept {
  for (std::size_t i = 0; i < streams_used_; ++i) {
    streams_[i].clock.decide_all();
    settle(streams_[i]);
  }
}

bool ScanClocks::pop(Record& out) noexcept {
  const int node = take_first(out_);
  if (node < 0) return false;
  out = nodes_[static_cast<std::size_t>(node)].record;
  append(free_, node);
  return true;
}

ClockFigures ScanClocks::figures(std::uint16_t channel) const noexcept {
  const int stream = channel < places_.size() ? places_[channel].stream : -1;
  return stream < 0 ? ClockFigures{} : streams_[static_cast<std::size_t>(stream)].clock.figures();
}

// Gives out the scans whose instants the clock has decided, the oldest first.
void ScanClocks::settle(Stream& stream) noexcept {
  DeviceClock::Instant instant;
  while (stream.clock.next(instant)) {
    if (stream.held.first < 0) continue;  // never: every arrival has a sample
    stream.instant = instant;
    stream.decided = nodes_[static_cast<std::size_t>(stream.held.first)].scan;
    while (stream.held.first >= 0 && nodes_[static_cast<std::size_t>(stream.held.first)].scan == stream.decided)
      give_out(take_first(stream.held), instant);
  }
}

void ScanClocks::give_out(int node, const DeviceClock::Instant& instant) noexcept {
  Record& record = nodes_[static_cast<std::size_t>(node)].record;
  const std::uint64_t half_ns = std::uint64_t{record.t_half_ns} + instant.half_ns;
  record.t_ns = instant.t_ns;
  record.t_half_ns =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(half_ns, std::numeric_limits<std::uint32_t>::max()));
  if (instant.after_loss) record.flags |= kGap;
  append(out_, node);
}

int ScanClocks::take_first(List& list) noexcept {
  const int node = list.first;
  if (node < 0) return -1;
  list.first = nodes_[static_cast<std::size_t>(node)].next;
  if (list.first < 0) list.last = -1;
  return node;
}

void ScanClocks::append(List& list, int node) noexcept {
  nodes_[static_cast<std::size_t>(node)].next = -1;
  if (list.last >= 0)
    nodes_[static_cast<std::size_t>(list.last)].next = node;
  else
    list.first = node;
  list.last = node;
}

}  // namespace dwell
