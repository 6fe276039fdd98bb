// Seeks the grid of a device's clock among its arrivals: collects a stretch, tries, collects a longer one, and pauses
// ever longer where none is found. Also keeps what is stated of the rate, for as long as it helps.
//
// Fixed storage, no allocation. Bound to one thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/stream/arrival_grid.hpp"

namespace dwell {

class GridSearch {
 public:
  // nominal_ns: the stated period, within 2 %; 0: not known.
  explicit GridSearch(double nominal_ns) noexcept : nominal_ns_(nominal_ns), next_pause_(kFirstPause) {}

  // Another arrival, not before the last; the grid, where one is found now. About 100 µs where it tries.
  [[nodiscard]] std::optional<ArrivalGrid> add(std::int64_t arrival_ns) noexcept;
  // The stretch of the grid just found: its first arrival, from which ArrivalGrid::last_ns counts, and its arrivals.
  [[nodiscard]] std::int64_t begin_ns() const noexcept { return stretch_[0]; }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }

  // Begins anew with the next arrival, without a pause.
  void restart() noexcept { count_ = pause_ = 0; }

  // The stated period; 0: none, or it was found wrong.
  [[nodiscard]] double nominal_ns() const noexcept { return nominal_ns_; }
  void forget_nominal() noexcept { nominal_ns_ = 0.0; }

 private:
  static constexpr std::size_t kShortStretch = 64;       // enough where jitter is small against the period
  static constexpr std::uint64_t kFirstPause = 256;      // arrivals between attempts that failed, doubling …
  static constexpr std::uint64_t kLongestPause = 65536;  // … so that a source without a rate costs nothing

  double nominal_ns_;
  std::array<std::int64_t, kLongestStretch> stretch_{};
  std::size_t count_ = 0;
  std::uint64_t pause_ = 0, next_pause_;  // arrivals still left aside; after the next failure
};

}  // namespace dwell
