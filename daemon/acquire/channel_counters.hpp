// What became of the samples of one channel: received = used + dropped + queued, at any moment, in every view.
//
// Two threads write: the device's thread (receive, refuse), the estimation thread (late, overflow, settle); each number
// has one writer. Any thread may read. The method: a sample is counted as received before it is offered to the ring,
// so before anything else can be counted of it; read() loads every other number first (acquire, pairing with the
// writers' release) and `received` last. So what read() found used or dropped has been counted as received, and
// `queued`, the difference, is never negative: it is exactly the samples received by the last load that had no fate yet
// at the first, in flight ones included. Lock-free, no allocation, real-time safe.
#pragma once

#include <atomic>
#include <cstdint>

namespace dwell {

// One consistent view of a channel's counters, in samples.
struct Tally {
  std::uint64_t received = 0;  // handed in by the device
  std::uint64_t used = 0;      // taken into account by the pipeline
  std::uint64_t refused = 0;   // dropped: the ring had no room for the scan
  std::uint64_t late = 0;      // dropped: older than what the merger had released
  std::uint64_t ahead = 0;     // dropped: stamped ahead of the clock
  std::uint64_t overflow = 0;  // dropped: the merger had no room
  std::uint64_t rejected = 0;  // dropped by the pipeline: not finite, overrange, not after the one before
  std::uint64_t queued = 0;    // on the way

  [[nodiscard]] std::uint64_t dropped() const noexcept { return refused + late + ahead + overflow + rejected; }
};

class ChannelCounters {
 public:
  // The device's thread.
  void receive() noexcept { add(received_, 1); }
  void refuse() noexcept { add(refused_, 1); }

  // The estimation thread. settle: how many samples the pipeline has used and rejected so far, both ever growing.
  void late() noexcept { add(late_, 1); }
  void ahead() noexcept { add(ahead_, 1); }
  void overflow() noexcept { add(overflow_, 1); }
  void settle(std::uint64_t used, std::uint64_t rejected) noexcept {
    used_.store(used, std::memory_order_release);
    rejected_.store(rejected, std::memory_order_release);
  }

  // Any thread.
  [[nodiscard]] Tally read() const noexcept {
    Tally t;
    t.used = used_.load(std::memory_order_acquire);
    t.rejected = rejected_.load(std::memory_order_acquire);
    t.late = late_.load(std::memory_order_acquire);
    t.ahead = ahead_.load(std::memory_order_acquire);
    t.overflow = overflow_.load(std::memory_order_acquire);
    t.refused = refused_.load(std::memory_order_acquire);
    t.received = received_.load(std::memory_order_acquire);
    t.queued = t.received - t.used - t.dropped();
    return t;
  }

 private:
  using Count = std::atomic<std::uint64_t>;
  // One writer, so no read-modify-write is needed.
  static void add(Count& count, std::uint64_t n) noexcept {
    count.store(count.load(std::memory_order_relaxed) + n, std::memory_order_release);
  }

  // Apart, so that the two writers do not share a cache line.
  alignas(64) Count received_{0};
  Count refused_{0};
  alignas(64) Count used_{0};
  Count rejected_{0};
  Count late_{0};
  Count ahead_{0};
  Count overflow_{0};
};

}  // namespace dwell
