// The readings of a hold from a little before its beginning on: what a transient is judged by, bounded in memory.
//
// Before a hold the newest readings are kept, for where it began is known only later. From then on nothing of it is
// overwritten. Once there is no more room, what comes is passed over: the beginning of a transient says most.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dwell {

// Bound to one thread, real-time safe but for the constructor and readings(). Memory: 24 bytes a reading.
class HoldRecord {
 public:
  struct Reading {
    std::int64_t t_ns = 0;  // on the run's axis of time
    double value = 0.0;
    int channel = 0;            // index into Rig::channels
    std::uint32_t half_ns = 0;  // half width of the instant's uncertainty
  };

  // capacity: readings, at least 1.
  explicit HoldRecord(std::size_t capacity) : ring_(capacity) {}

  // false: there is no room; the reading is passed over.
  bool push(const Reading& reading) noexcept {
    if (full()) {
      passed_over_ = true;
      return false;
    }
    ring_[static_cast<std::size_t>(end_++ % ring_.size())] = reading;
    return true;
  }

  // A hold begins with the first reading at or after from_ns that is still there. At most half of the room goes to
  // readings from before now; older ones are left out. O(readings).
  void begin(std::int64_t from_ns) noexcept {
    roll();
    begin_ = oldest();
    while (begin_ < end_ && (at(begin_).t_ns < from_ns || end_ - begin_ > ring_.size() / 2)) ++begin_;
    holds_ = true;
  }
  // Ends the hold: the ring overwrites its oldest readings again.
  void roll() noexcept {
    if (passed_over_) first_ = end_;  // a gap: nothing before it may stand beside what comes
    passed_over_ = holds_ = false;
  }
  // Protects the hold's readings again, after roll(). false: some are gone.
  bool resume() noexcept {
    if (begin_ < oldest()) return false;
    holds_ = true;
    return true;
  }

  // Of the hold.
  [[nodiscard]] std::size_t size() const noexcept {
    return static_cast<std::size_t>(end_ - std::max(begin_, oldest()));
  }
  [[nodiscard]] bool full() const noexcept { return holds_ && end_ - begin_ == ring_.size(); }
  // A copy of them, in the order in which they came. Allocates; O(readings).
  [[nodiscard]] std::vector<Reading> readings() const {
    std::vector<Reading> out;
    out.reserve(size());
    for (std::uint64_t i = std::max(begin_, oldest()); i < end_; ++i) out.push_back(at(i));
    return out;
  }

 private:
  [[nodiscard]] const Reading& at(std::uint64_t number) const noexcept {
    return ring_[static_cast<std::size_t>(number % ring_.size())];
  }
  [[nodiscard]] std::uint64_t oldest() const noexcept {
    return std::max(first_, end_ - std::min<std::uint64_t>(end_, ring_.size()));
  }

  std::vector<Reading> ring_;
  std::uint64_t first_ = 0, begin_ = 0, end_ = 0;  // numbers: nothing older counts; the hold's first; the next
  bool holds_ = false;                             // nothing from begin_ on is overwritten
  bool passed_over_ = false;                       // a reading was refused since the last roll()
};

}  // namespace dwell
