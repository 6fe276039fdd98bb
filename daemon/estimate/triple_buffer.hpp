// Hands the newest value from one writer thread to one reader thread; neither ever waits, values in between are
// skipped.
//
// Three slots: the writer fills its own and swaps it for the middle one, the reader swaps the middle one for its own
// when it is newer. Lock-free; publishing and reading cost one atomic exchange.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace dwell {

template <class T>
class TripleBuffer {
 public:
  // The writer's slot: fill it, then publish. It holds an older value, whose storage may be reused.
  [[nodiscard]] T& back() noexcept { return slots_[back_].value; }
  void publish() noexcept {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }

  // The reader: moves on to the newest value; false: nothing newer than front() was published.
  bool update() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  // The value the reader has, unchanged until its next update().
  [[nodiscard]] const T& front() const noexcept { return slots_[front_].value; }

 private:
  static constexpr std::uint8_t kFresh = 4;
  static constexpr std::uint8_t kIndex = 3;
  struct alignas(64) Slot {
    T value{};
  };
  std::array<Slot, 3> slots_{};
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t back_ = 0;   // the writer's
  alignas(64) std::uint8_t front_ = 2;  // the reader's
};

}  // namespace dwell
