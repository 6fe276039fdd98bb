// Remembers the last few numbers that a channel has shown.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

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
  // Adds the last of these numbers as add() would add all of them: only N of them can be remembered.
  void add_all(std::span<const double> numbers) noexcept {
    for (const double number : numbers.last(std::min(numbers.size(), N))) add(number);
  }
  // Whether it remembers exactly these, the oldest first, to the bit.
  [[nodiscard]] bool are(std::span<const double, N> numbers) const noexcept {
    std::uint64_t differ = 0;
    for (std::size_t i = 0; i < N; ++i)
      differ |= std::bit_cast<std::uint64_t>(numbers_[place(i)]) ^ std::bit_cast<std::uint64_t>(numbers[i]);
    return differ == 0;
  }
  // The numbers remembered, the oldest first; NaN: none yet.
  void copy_to(std::span<double, N> numbers) const noexcept {
    for (std::size_t i = 0; i < N; ++i) numbers[i] = numbers_[place(i)];
  }
  // NaN: none yet.
  [[nodiscard]] double newest() const noexcept { return numbers_[next_ > 0 ? next_ - 1 : N - 1]; }

 private:
  // Of the i-th number, counted from the oldest.
  [[nodiscard]] std::size_t place(std::size_t i) const noexcept { return next_ + i < N ? next_ + i : next_ + i - N; }

  std::array<double, N + N % 2> numbers_;  // of an odd N one place stays NaN
  std::size_t next_ = 0;
};

}  // namespace dwell
