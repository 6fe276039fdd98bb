// What leaves the estimation thread: snapshots, of which the reader sees the newest, and run events, of which it sees
// every one. Neither side ever waits for the other.
#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <functional>
#include <utility>

#include "daemon/estimate/snapshot.hpp"
#include "daemon/estimate/triple_buffer.hpp"

namespace dwell {

class Publisher {
 public:
  // Events that wait at most: some seconds of a drive that comes and goes with every period. Each holds a whole dwell,
  // at 30 elements 0.2 MB. Further ones are lost, and counted.
  static constexpr std::size_t kEvents = 64;

  // wake: called on the estimation thread when there is something new; must not block.
  explicit Publisher(std::function<void()> wake) : wake_(std::move(wake)) {}
  // The queue does not destroy what is left in it.
  ~Publisher() {
    for (RunEvent left; events_.pop(left);) {
    }
  }
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  // The estimation thread: the snapshot to fill, with its number in it, then to publish.
  [[nodiscard]] Snapshot& next() noexcept {
    Snapshot& to = snapshots_.back();
    to.sequence = sequence_ + 1;
    return to;
  }
  void publish() {
    ++sequence_;
    snapshots_.publish();
    wake_();
  }
  void tell(RunEvent event) {
    event.lost = lost_;
    lost_ = events_.push(std::move(event)) ? 0 : lost_ + 1;
    wake_();
  }

  // The one reader: moves on to the newest snapshot; false: there was no newer one.
  bool refresh() noexcept { return snapshots_.update(); }
  [[nodiscard]] const Snapshot& latest() const noexcept { return snapshots_.front(); }
  // The next event; false: there is none.
  bool next_event(RunEvent& out) { return events_.pop(out); }

 private:
  std::function<void()> wake_;
  std::uint64_t sequence_ = 0;
  std::uint64_t lost_ = 0;  // since the last event that found room
  TripleBuffer<Snapshot> snapshots_;
  boost::lockfree::spsc_queue<RunEvent, boost::lockfree::capacity<kEvents>> events_;
};

}  // namespace dwell
