// Remembers the last few numbers that a channel has shown.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/packed.hpp"

namespace dwell {

// One thread; real-time safe; N / 2 comparisons to look for a number.
template <std::size_t N>
class RecentNumbers {
 public:
  static constexpr std::size_t kRemembered = N;

  RecentNumbers() noexcept { numbers_.fill(NAN); }
  // Forgets the oldest.
  void add(double number) noexcept {
    numbers_[next_] = number;
    next_ = next_ + 1 < N ? next_ + 1 : 0;
  }
  [[nodiscard]] bool has(double number) const noexcept {
    Packed<std::int64_t> found{};  // left to itself, GCC compares one by one, in three times as many instructions
    for (std::size_t i = 0; i < numbers_.size(); i += 2)
      found |= Packed<double>{numbers_[i], numbers_[i + 1]} == Packed<double>{number, number};
    return (found[0] | found[1]) != 0;
  }
  // NaN: none yet.
  [[nodiscard]] double newest() const noexcept { return numbers_[next_ > 0 ? next_ - 1 : N - 1]; }

 private:
  std::array<double, N + N % 2> numbers_;  // of an odd N one place stays NaN
  std::size_t next_ = 0;
};

}  // namespace dwell
