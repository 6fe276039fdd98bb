// Assembles the one ordered stream from the raw records of the devices: a sample passes the clocks of its device, then
// the merger. The service and `identify` both use it. Only a recording whose stamps all stand needs no assembler.
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
    std::vector<std::uint16_t> channels;  // Rig::channels indices; empty: samples of this device are not taken
    double rate_hz = 0.0;                 // the rate set in the device; 0: not known
    bool leads = false;                   // stamps may run ahead of the time: Merger::set_leading()
  };
  // The sources of a rig, one per device, as the rig file states them.
  [[nodiscard]] static std::vector<Source> sources(const Rig& rig);

  // hold_back_ns: how long the merger waits for the slowest source; capacity: records held at most of each source.
  Assembler(const std::vector<Source>& devices, std::int64_t hold_back_ns, std::size_t capacity);

  // It is now_ns; see Merger::set_now().
  void set_now(std::int64_t now_ns) noexcept { merger_.set_now(now_ns); }

  // Hands in the next sample of a device, in the order of arrival. This may decide the instants of several samples,
  // which then go on to the merger. Just before, enter(Record&) may mark each of them. Just after, admitted(const
  // Record&, Merger::Admission) is told whether the merger took it.
  template <class Enter, class Admitted>
  void sample(std::size_t device, const Record& record, Enter enter, Admitted admitted) {
    clocks_[device].push(record);
    hand_on(device, enter, admitted);
  }
  // It is now_ns, and all samples that this device has delivered have been handed in.
  template <class Enter, class Admitted>
  void wait(std::size_t device, std::int64_t now_ns, Enter enter, Admitted admitted) {
    clocks_[device].wait(now_ns);
    hand_on(device, enter, admitted);
  }
  // The device has stopped: samples held go on. Its next record makes the merger wait for it again.
  template <class Enter, class Admitted>
  void stopped(std::size_t device, Enter enter, Admitted admitted) {
    clocks_[device].flush();
    hand_on(device, enter, admitted);
    merger_.set_live(device, false);
  }

  // Hands in a change of state of a device's channel. It is never late: if it is older than the newest record released,
  // it takes that record's instant. false: the device's queue is full; hand it in again.
  bool state(std::size_t device, Record record) noexcept { return enter_now(device, record); }
  // As state(), for an action or another record that no device stamps and that must not be late.
  bool action(Record record) noexcept { return enter_now(ticks(), record); }
  // Time goes on, with or without other records. A tick is late only where a recording is played faster than real time,
  // which needs no ticks.
  void tick(std::int64_t now_ns) noexcept { merger_.push(ticks(), tick_at(now_ns)); }
  // An edge of a GPIO line, at its own instant.
  Merger::Admission edge(const Record& record) noexcept { return merger_.push(edges(), record); }
  // As state(), for an edge that must not be late.
  bool urgent_edge(Record record) noexcept { return enter_now(edges(), record); }
  // All edges up to this instant have been handed in.
  void edges_seen_to(std::int64_t t_ns) noexcept {
    if (t_ns > released_ns_) merger_.push(edges(), tick_at(t_ns));
  }

  // The next record of the stream; false: none may be released yet.
  bool next(Record& out) noexcept { return released(merger_.pop(out), out); }
  // As next(), without waiting: for the end of a run.
  bool flush(Record& out) noexcept { return released(merger_.flush(out), out); }

  // Figures of the clock that stamps this channel of the device.
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
