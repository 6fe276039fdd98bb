// One device as the estimation hears it: what its ring holds goes on into the stream; whether its channels deliver is
// judged, told to the stream and to the log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/stream/assembler.hpp"
#include "daemon/acquire/device_link.hpp"
#include "daemon/estimate/channel_watch.hpp"
#include "daemon/estimate/device_lines.hpp"
#include "daemon/estimate/leaps.hpp"
#include "daemon/estimate/lost_and_faulty.hpp"
#include "daemon/estimate/snapshot.hpp"
#include "daemon/estimate/stream_accounts.hpp"
#include "daemon/log/log.hpp"

namespace dwell {

// A device as it is given to the estimation.
struct DeviceFeed {
  DeviceLink* link = nullptr;  // must outlive the estimation
  std::string driver = {};     // which plugin
  double rate_hz = 0.0;        // polls a second that the rig file asks for; 0: not known
  bool leads = false;          // its stamps may run ahead of the clock
  bool recorded = false;       // it plays a recording
};

// Virtual time: every now_ns is CLOCK_MONOTONIC_RAW. Bound to the estimation thread; no allocation per sample.
class DeviceIntake {
 public:
  // A driver that has not turned for so long hangs: the interface asks for a turn every 0.5 s; six times that is no
  // stall.
  static constexpr std::int64_t kHung_ns = 3'000'000'000;

  // index: in Rig::devices. hold_back_ns: how far the merger waits. Rig, assembler and log must outlive this.
  DeviceIntake(std::size_t index, DeviceFeed feed, const Rig& rig, Assembler& assembler, std::int64_t hold_back_ns,
               Log& log, std::int64_t now_ns);

  // Hands on everything that the device has handed in.
  void take(std::int64_t now_ns);
  // Looks for what the driver does not say of itself: that it hangs, is silent, or delivers what cannot be put in
  // order.
  void find_faults(std::int64_t now_ns);
  // States for which the merger had no room; none is ever lost.
  void offer_states();
  // Tells the stream which samples never reached it, and which faults the device counted.
  void account(std::int64_t now_ns);
  // The run ends: what its clocks hold goes on.
  void stop(std::int64_t now_ns);

  // Counts what became of its samples so far.
  void settle(const StreamAccounts& accounts);
  // Faults that no line of the log has told of yet.
  void tell_counted_faults(std::int64_t now_ns);
  // The run has ended.
  void tell_end();
  // Fills in its device and its channels.
  void show(const Rig& rig, const Pipeline& pipeline, const StreamAccounts& accounts, std::int64_t now_ns,
            Snapshot& to);

 private:
  struct Heard {
    Heard(std::uint16_t rig_channel, std::string its_name, double rate_hz, std::int64_t now_ns)
        : index(rig_channel), name(std::move(its_name)), watch(rate_hz, now_ns) {}

    std::uint16_t index;  // in Rig::channels
    std::string name;
    ChannelWatch watch;
    bool gap = false;  // samples were lost on the way to the merger
    double half_width_s = 0.0;
    std::optional<Record> state;  // its newest change of state, for which the merger had no room
    // Since when none of its samples could be put in order (0: they can), and by which the newest was too old
    // (negative: stamped ahead of the clock).
    std::int64_t untimely_since_ns = 0;
    std::int64_t untimely_by_ns = 0;
    // What the log is not told of yet.
    bool recovered = false;
    bool stale = false;
    std::int64_t stale_ns = 0;  // of recovered: for how long it had been stale
    bool ever_heard = false;
    Leaps leaps;

    void lost(std::int64_t t_ns, std::int64_t now_ns) noexcept;
    void recover(std::int64_t for_ns) noexcept;
  };

  void take_events();
  void take_samples(std::int64_t now_ns);
  void heard(const Record& record, std::int64_t now_ns);
  [[nodiscard]] bool stamped_ahead(const Record& record, std::int64_t now_ns);
  void enters(Record& record);
  void admitted(const Record& record, Merger::Admission admission, std::int64_t now_ns);
  void admit_state(Heard& channel, std::int64_t t_ns, Fault fault);
  void goes_stale(Heard& channel, Fault fault, const std::string& reason, std::int64_t now_ns);
  void find_hung(std::int64_t now_ns);
  void find_silence(std::int64_t now_ns);
  void find_untimely(std::int64_t now_ns);
  void tell_recoveries(std::int64_t now_ns);
  void tell_stale(std::int64_t now_ns);
  [[nodiscard]] bool all(Fault fault) const noexcept;
  [[nodiscard]] std::uint64_t occurrences(Fault fault) const noexcept;
  [[nodiscard]] Heard& channel(const Record& record) noexcept {
    return channels_[static_cast<std::size_t>(feed_.link->position(record.channel))];
  }
  [[nodiscard]] ChannelCounters& counters(const Record& record) noexcept {
    return feed_.link->counters(feed_.link->position(record.channel));
  }

  const std::size_t index_;
  const DeviceFeed feed_;
  Assembler& assembler_;
  const std::int64_t hold_back_ns_;
  std::vector<Heard> channels_;  // by DeviceLink::position
  DeviceLines lines_;
  LostAndFaulty accounts_;
  std::vector<Record> scratch_;
  std::uint64_t silences_ = 0;  // times that channels fell silent
  std::uint64_t untimely_ = 0;  // times that nothing of a channel could be put in order
  bool hangs_ = false;          // its driver has not turned for too long
};

}  // namespace dwell
