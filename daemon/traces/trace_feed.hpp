// Carries the records that traces are drawn from, from the estimation thread to the event loop. Bounded; neither side
// ever waits for the other.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>

#include "core/stream/record.hpp"

namespace dwell {

class TraceFeed {
 public:
  // 4 MB: 2 s of 64 channels at 1 kHz. The event loop should never be busy for longer. Halved: a long answer of the
  // server leaves a gap in the traces of such a rig. Doubled: 4 MB more for every rig.
  static constexpr std::size_t kRecords = 131'072;

  TraceFeed() : waiting_(kRecords) {}

  // The estimation thread, for every record of the stream as merged. Real-time safe.
  void take(const Record& record) noexcept {
    if (record.kind != Kind::sample && record.kind != Kind::tick && record.kind != Kind::channel_state) return;
    if (!waiting_.push(record)) lost_.fetch_add(1, std::memory_order_relaxed);
  }

  // The event loop: hands over the records that waited when it was called, in order.
  template <class Take>
  void drain(Take take) {
    waiting_.consume_all(take);
  }
  // Records for which there was no room, since the start. Any thread.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<Record> waiting_;
  std::atomic<std::uint64_t> lost_{0};
};

}  // namespace dwell
