// A run of plain readings of one channel: evenly spaced, each other than the sixteen before it, within all ranges seen
// before, and as the motion predicts.
//
// Nearly all readings are plain. All that judges them then finds nothing, and only counts. So a run is judged at once:
// what is the same for each of its readings is done once, and the rest in loops that touch nothing else. Whatever is
// not plain ends the run, and is judged by itself (ChannelIntake::judge).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/packed.hpp"

namespace dwell {

// Of one channel, in the device's own numbers. Scratch memory; one thread, real-time safe.
class PlainRun {
 public:
  // Readings before the run with which its first is compared: RecurringNumbers looks back farthest.
  static constexpr std::size_t kBefore = 16;
  // Longest run. With half as many what is done once a run counts twice; longer ones no longer fit the fastest cache.
  static constexpr std::size_t kMost = 64;
  // Shortest run that costs less than its readings by themselves.
  static constexpr std::size_t kFewest = 8;

  // Begins a run after a reading at before_ns, in steps of gap_ns.
  void begin(std::int64_t before_ns, std::int64_t gap_ns) noexcept {
    count_ = 0;
    before_ns_ = before_ns;
    gap_ns_ = gap_ns;
    due_ns_ = before_ns + gap_ns;
  }
  // There is none: no reading is added.
  void close() noexcept {
    count_ = 0;
    due_ns_ = INT64_MIN;
  }
  // Adds the channel's next reading. It may end the run instead; then no later one is added either.
  void add(std::int64_t t_ns, double number, std::uint32_t half_ns, bool flagged) noexcept {
    if (count_ == 0) half_ns_ = half_ns;
    if (t_ns != due_ns_ || half_ns != half_ns_ || flagged || count_ == kMost) {
      due_ns_ = INT64_MIN;
      return;
    }
    due_ns_ += gap_ns_;
    numbers_[kBefore + count_++] = number;
  }
  // Takes one reading away; false: none is left.
  bool pop() noexcept {
    if (count_ == 0) return false;
    --count_;
    return true;
  }
  // Keeps the first n readings.
  void shorten(std::size_t n) noexcept { count_ = n; }

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::int64_t before_ns() const noexcept { return before_ns_; }
  [[nodiscard]] std::int64_t gap_ns() const noexcept { return gap_ns_; }
  [[nodiscard]] std::uint32_t half_ns() const noexcept { return half_ns_; }
  // The instant of the last reading that is kept.
  [[nodiscard]] std::int64_t last_ns() const noexcept {
    return before_ns_ + gap_ns_ * static_cast<std::int64_t>(count_);
  }
  // The i-th reading; negative: of those before.
  [[nodiscard]] double at(std::ptrdiff_t i) const noexcept {
    return numbers_[static_cast<std::size_t>(i + static_cast<std::ptrdiff_t>(kBefore))];
  }
  [[nodiscard]] double last() const noexcept { return numbers_[kBefore + count_ - 1]; }
  // Those that are kept.
  [[nodiscard]] std::span<const double> readings() const noexcept { return {&numbers_[kBefore], count_}; }
  // The last n readings up to the i-th, that one left out; the oldest first.
  [[nodiscard]] std::span<const double> before(std::size_t i, std::size_t n) const noexcept {
    return {&numbers_[kBefore + i - n], n};
  }
  [[nodiscard]] std::span<double, kBefore> before() noexcept {
    return std::span<double, kBefore>(numbers_.data(), kBefore);
  }
  // Whether the i-th reading equals one of the kBefore before it.
  [[nodiscard]] bool recurs(std::size_t i) const noexcept {
    const double* const old = &numbers_[i];
    const double number = numbers_[kBefore + i];
    Packed<std::int64_t> found{};
    for (std::size_t k = 0; k < kBefore; k += 2)
      found |= Packed<double>{old[k], old[k + 1]} == Packed<double>{number, number};
    return (found[0] | found[1]) != 0;
  }
  struct Range {
    double low, high;
    void see(double number) noexcept {
      low = number < low ? number : low;
      high = number > high ? number : high;
    }
  };
  // Of the readings that are kept but the last; there must be one. low is INFINITY where these are none.
  [[nodiscard]] Range range_but_last() const noexcept {
    Range range{INFINITY, -INFINITY};
    for (std::size_t i = 0; i + 1 < count_; ++i) range.see(numbers_[kBefore + i]);
    return range;
  }

 private:
  std::array<double, kBefore + kMost> numbers_{};
  std::size_t count_ = 0;
  std::int64_t before_ns_ = 0, gap_ns_ = 0;
  std::int64_t due_ns_ = INT64_MIN;  // when the next reading must come; INT64_MIN: the run has ended
  std::uint32_t half_ns_ = 0;
};

}  // namespace dwell
