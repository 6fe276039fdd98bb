// Keeps readings between their arrival and the moment they are given out, in the order of arrival. A reading first
// waits until its instant is decided, then until it is taken.
//
// Fixed storage, no allocation. Bound to one thread; real-time safe.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>

namespace dwell {

// The instant of a reading by its device's clock.
struct DeviceInstant {
  std::int64_t t_ns = 0;      // with a recovered clock: later than the one before, always
  std::uint32_t half_ns = 0;  // half width of the recovery's uncertainty; 0 where t_ns is the arrival
  bool after_loss = false;    // readings just before it never arrived
};

class HeldArrivals {
 public:
  static constexpr std::size_t kCapacity = 256;

  [[nodiscard]] bool full() const noexcept { return count_ == kCapacity; }
  // A reading arrived. Only if not full().
  void add(std::int64_t arrival_ns) noexcept {
    assert(!full());
    at(count_++).arrival_ns = arrival_ns;
  }
  // The number of undecided readings, and the arrival of the i-th of them.
  [[nodiscard]] std::size_t waiting() const noexcept { return count_ - decided_; }
  [[nodiscard]] std::int64_t arrival_ns(std::size_t i) const noexcept {
    return ring_[(first_ + decided_ + i) % kCapacity].arrival_ns;
  }
  // Decides the instant of the oldest undecided reading.
  void decide(const DeviceInstant& instant) noexcept {
    assert(waiting() > 0);
    at(decided_++).instant = instant;
  }
  // Takes the oldest decided reading; false: there is none.
  bool take(DeviceInstant& out) noexcept {
    if (decided_ == 0) return false;
    out = at(0).instant;
    first_ = (first_ + 1) % kCapacity;
    --count_;
    --decided_;
    return true;
  }

 private:
  struct Held {
    std::int64_t arrival_ns = 0;
    DeviceInstant instant;
  };
  [[nodiscard]] Held& at(std::size_t i) noexcept { return ring_[(first_ + i) % kCapacity]; }

  std::array<Held, kCapacity> ring_{};
  std::size_t first_ = 0, decided_ = 0, count_ = 0;  // index of the oldest; decided ones; all held
};

}  // namespace dwell
