// Readings between their arrival and the moment they are given out: first they wait to be decided upon, then their
// instant is known and they wait to be taken. In the order of arrival, at most kCapacity of them.
//
// Fixed storage, no allocation. Bound to one thread; real-time safe.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>

namespace dwell {

// The instant of a reading, as a device's clock has it.
struct DeviceInstant {
  std::int64_t t_ns = 0;      // locked: after the one before, always
  std::uint32_t half_ns = 0;  // half width of what the recovery is uncertain by; 0 where the arrival stands
  bool after_loss = false;    // readings before it never arrived
};

class HeldArrivals {
 public:
  static constexpr std::size_t kCapacity = 256;

  [[nodiscard]] bool full() const noexcept { return count_ == kCapacity; }
  // A reading that arrived last; none may be added while full.
  void add(std::int64_t arrival_ns) noexcept {
    assert(!full());
    at(count_++).arrival_ns = arrival_ns;
  }
  // How many are not decided upon, and when the i-th of these arrived.
  [[nodiscard]] std::size_t waiting() const noexcept { return count_ - decided_; }
  [[nodiscard]] std::int64_t arrival_ns(std::size_t i) const noexcept {
    return ring_[(first_ + decided_ + i) % kCapacity].arrival_ns;
  }
  // The oldest that waits has this instant.
  void decide(const DeviceInstant& instant) noexcept {
    assert(waiting() > 0);
    at(decided_++).instant = instant;
  }
  // The oldest that is decided upon goes out; false: there is none.
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
  std::size_t first_ = 0, decided_ = 0, count_ = 0;  // the oldest; so many of count_ have their instant
};

}  // namespace dwell
