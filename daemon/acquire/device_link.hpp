// The way from a driver's thread to the estimation thread: one ring of samples, one of state changes, and the counters.
//
// Bounded and lock-free; one producer (the driver's thread, through the dwell_host callbacks), one consumer (the
// estimation thread). A scan enters the ring whole or is refused whole; the gap a refusal leaves is marked on the next
// accepted sample of each channel concerned. State changes have a small ring of their own, so that a full sample ring
// never hides a fault; where even that is full the newest change of each channel waits for room: intermediate ones are
// lost, the last never is.
#pragma once

#include <array>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/acquire/channel_counters.hpp"
#include "drivers/dwell_driver.h"

namespace dwell {

// The driver said that a channel does not deliver, or does again.
struct StateEvent {
  static constexpr std::size_t kReasonSize = 160;
  std::int64_t t_ns = 0;      // when it was said
  std::int32_t channel = -1;  // Rig::channels index; -1: every channel of the device
  Fault fault = Fault::none;
  std::array<char, kReasonSize> reason{};  // zero-terminated, printable; empty: none given
};

class DeviceLink {
 public:
  // What a driver says in words; called on the driver's thread.
  using LogLine = std::function<void(dwell_level, const char*)>;

  // channels: Rig::channels indices of this device; capacity: samples the ring holds.
  DeviceLink(std::string name, std::vector<std::uint16_t> channels, std::size_t capacity, LogLine log);
  DeviceLink(const DeviceLink&) = delete;
  DeviceLink& operator=(const DeviceLink&) = delete;

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] const std::vector<std::uint16_t>& channels() const noexcept { return channels_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }

  // The callbacks for dwell_driver_table::create; valid as long as this object, which must not move.
  [[nodiscard]] dwell_host host() noexcept;

  // The driver's thread; push is real-time safe. push returns false when the scan was refused: no room, or (counted as
  // foreign) a channel that is not this device's.
  bool push(const dwell_sample* samples, std::size_t count) noexcept;
  void state(std::int32_t channel, dwell_fault fault, const char* reason) noexcept;
  void count(dwell_fault fault, std::uint64_t occurrences = 1) noexcept;
  void turn(std::int64_t now_ns) noexcept;
  // How many samples the next push is sure to find room for. Real-time safe.
  [[nodiscard]] std::size_t room() const noexcept { return samples_.write_available(); }

  // Any thread: from now on nothing that the driver says goes anywhere. For one that cannot be stopped.
  void abandon() noexcept { abandoned_.store(true, std::memory_order_release); }

  // The estimation thread. Take the events before the samples: then every sample pushed before an event is seen with
  // it.
  bool pop_event(StateEvent& out) noexcept { return events_.pop(out); }
  std::size_t pop_samples(Record* out, std::size_t room) noexcept;

  // The position of a channel among channels(); -1: not of this device. Any thread.
  [[nodiscard]] int position(std::size_t channel) const noexcept {
    return channel < positions_.size() ? positions_[channel] : -1;
  }
  // By position. late, overflow and settle belong to the estimation thread.
  [[nodiscard]] ChannelCounters& counters(int position) noexcept {
    return own_[static_cast<std::size_t>(position)].counters;
  }

  // Any thread.
  [[nodiscard]] std::uint64_t faults(Fault fault) const noexcept;
  [[nodiscard]] std::uint64_t foreign() const noexcept { return foreign_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t last_turn_ns() const noexcept { return last_turn_ns_.load(std::memory_order_relaxed); }
  // Samples that have entered and left the ring, for the watchdog.
  [[nodiscard]] std::uint64_t entered() const noexcept { return entered_.load(std::memory_order_acquire); }
  [[nodiscard]] std::uint64_t left() const noexcept { return left_.load(std::memory_order_acquire); }

 private:
  struct Own {
    ChannelCounters counters;
    // The driver's thread alone.
    bool gap = false;                   // samples were lost before the next one
    std::optional<StateEvent> waiting;  // the newest change for which there was no room
  };

  void offer_waiting() noexcept;
  void mark_gaps(const dwell_sample* samples, std::size_t count) noexcept;

  const std::string name_;
  const std::vector<std::uint16_t> channels_;
  const std::size_t capacity_;
  const LogLine log_;
  std::vector<std::int16_t> positions_;  // by Rig::channels index
  std::unique_ptr<Own[]> own_;           // by position

  boost::lockfree::spsc_queue<Record> samples_;
  boost::lockfree::spsc_queue<StateEvent> events_;

  bool any_waiting_ = false;  // the driver's thread alone

  std::array<std::atomic<std::uint64_t>, kFaultCount> faults_{};
  std::atomic<std::uint64_t> foreign_{0};
  std::atomic<std::uint64_t> entered_{0};
  std::atomic<std::uint64_t> left_{0};
  std::atomic<std::int64_t> last_turn_ns_;
  std::atomic<bool> abandoned_{false};
};

}  // namespace dwell
