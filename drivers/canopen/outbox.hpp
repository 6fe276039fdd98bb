// Frames that are to be sent, in order. Bounded: what finds no room is dropped and counted. Nothing allocates.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/canopen/message.hpp"

namespace dwell::canopen {

class Outbox {
 public:
  static constexpr std::size_t kRoom = 512;  // of 127 nodes each an abort, a request and two commands

  void push(const can_frame& frame) noexcept {
    if (count_ == kRoom) {
      ++dropped_;
      return;
    }
    frames_[(first_ + count_++) % kRoom] = frame;
  }
  // Null: nothing.
  [[nodiscard]] const can_frame* front() const noexcept { return count_ == 0 ? nullptr : &frames_[first_]; }
  void pop() noexcept {
    first_ = (first_ + 1) % kRoom;
    --count_;
  }
  void clear() noexcept { first_ = count_ = 0; }
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

 private:
  std::array<can_frame, kRoom> frames_{};
  std::size_t first_ = 0, count_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace dwell::canopen
