// Remembers the last few numbers that a channel has shown.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace dwell {

// One thread; real-time safe; N comparisons to look for a number.
template <std::size_t N>
class RecentNumbers {
 public:
  static constexpr std::size_t kRemembered = N;

  RecentNumbers() noexcept { numbers_.fill(NAN); }
  // Forgets the oldest.
  void add(double number) noexcept {
    numbers_[next_] = number;
    next_ = (next_ + 1) % N;
  }
  [[nodiscard]] bool has(double number) const noexcept {
    std::int64_t found = 0;  // as wide as a number and without a branch: two comparisons at once
    for (const double one : numbers_) found |= one == number ? -1 : 0;
    return found != 0;
  }
  // NaN: none yet.
  [[nodiscard]] double newest() const noexcept { return numbers_[(next_ + N - 1) % N]; }

 private:
  std::array<double, N> numbers_;
  std::size_t next_ = 0;
};

}  // namespace dwell
