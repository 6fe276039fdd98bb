// From the raw records of devices to the one ordered stream: each sample passes the clocks of its device and then the
// merger. Service and `identify` use this one way; only a recording whose every stamp stands needs none.
//
//   device 0 ─ clocks ─┐
//   device 1 ─ clocks ─┼─ merger ─ next()
//   edges, ticks ──────┘
//
// Pure, virtual time, memory fixed at construction; bound to one thread, real-time safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/stream/merger.hpp"
#include "core/stream/record.hpp"
#include "core/stream/scan_clocks.hpp"

namespace dwell {

class Assembler {
 public:
  struct Source {
    Clock clock = Clock::host;
    std::vector<std::uint16_t> channels;  // Rig::channels indices; none: the device is not heard
    double rate_hz = 0.0;                 // what it is set to; 0: not known
    bool leads = false;                   // its stamps may run ahead of the time
  };
  // The devices of a rig, by what the rig file states of each.
  [[nodiscard]] static std::vector<Source> sources(const Rig& rig);

  // hold_back_ns: how far the slowest source is waited for; capacity: records held at most of each source.
  Assembler(const std::vector<Source>& devices, std::int64_t hold_back_ns, std::size_t capacity);

  // It is now_ns; see Merger::set_now().
  void set_now(std::int64_t now_ns) noexcept { merger_.set_now(now_ns); }

  // The next sample of a device, in the order of arrival. The samples whose instants this decides go on to the merger:
  // enter(Record&) may mark each just before, admitted(const Record&, Merger::Admission) is told what became of it.
  template <class Enter, class Admitted>
  void sample(std::size_t device, const Record& record, Enter enter, Admitted admitted) {
    clocks_[device].push(record);
    hand_on(device, enter, admitted);
  }
  // It is now_ns, and all that this device has delivered has been handed in.
  template <class Enter, class Admitted>
  void wait(std::size_t device, std::int64_t now_ns, Enter enter, Admitted admitted) {
    clocks_[device].wait(now_ns);
    hand_on(device, enter, admitted);
  }
  // The device has stopped: what its clocks hold goes on, and it is not waited for until its next record.
  template <class Enter, class Admitted>
  void stopped(std::size_t device, Enter enter, Admitted admitted) {
    clocks_[device].flush();
    hand_on(device, enter, admitted);
    merger_.set_live(device, false);
  }

  // Hands in a change of state of a device's channel. It is never dropped as late: where its instant lies before the
  // newest record released, it takes that record's instant. false: the device's queue is full; hand it in again.
  bool state(std::size_t device, Record record) noexcept { return enter_now(device, record); }
  // An action, or another record that no device stamps and that must not be late; as state().
  bool action(Record record) noexcept { return enter_now(ticks(), record); }
  // Time goes on, whether or not anything happens. Dropped as late only where a recording is played faster than real
  // time, which needs no ticks.
  void tick(std::int64_t now_ns) noexcept { merger_.push(ticks(), tick_at(now_ns)); }
  // An edge of a GPIO line, at its own instant.
  Merger::Admission edge(const Record& record) noexcept { return merger_.push(edges(), record); }
  // An edge that must not be late; as state().
  bool urgent_edge(Record record) noexcept { return enter_now(edges(), record); }
  // All edges up to this instant have been handed in.
  void edges_seen_to(std::int64_t t_ns) noexcept {
    if (t_ns > released_ns_) merger_.push(edges(), tick_at(t_ns));
  }

  // The next record of the stream; false: none may be released yet.
  bool next(Record& out) noexcept { return released(merger_.pop(out), out); }
  // The same without waiting, for the end of a run.
  bool flush(Record& out) noexcept { return released(merger_.flush(out), out); }

  // Of the clock behind a channel of the device.
  [[nodiscard]] ClockFigures figures(std::size_t device, std::uint16_t channel) const noexcept {
    return clocks_[device].figures(channel);
  }

 private:
  template <class Enter, class Admitted>
  void hand_on(std::size_t device, Enter enter, Admitted admitted) {
    for (Record record; clocks_[device].pop(record);) {
      enter(record);
      admitted(record, merger_.push(device, record));
    }
  }
  [[nodiscard]] std::size_t edges() const noexcept { return clocks_.size(); }
  [[nodiscard]] std::size_t ticks() const noexcept { return clocks_.size() + 1; }
  static Record tick_at(std::int64_t t_ns) noexcept {
    Record tick;
    tick.t_ns = t_ns;
    tick.kind = Kind::tick;
    return tick;
  }
  bool enter_now(std::size_t source, Record& record) noexcept {
    record.t_ns = std::max(record.t_ns, released_ns_);
    return merger_.push(source, record) != Merger::Admission::full;
  }
  bool released(bool any, const Record& record) noexcept {
    if (any) released_ns_ = record.t_ns;
    return any;
  }

  std::vector<ScanClocks> clocks_;  // by device
  Merger merger_;
  std::int64_t released_ns_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace dwell
