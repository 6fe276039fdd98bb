// Seeks the grid of a device's clock among its arrivals. It tries a short stretch, then a longer one. After a failure
// it pauses, twice as long each time. It keeps the stated rate until that proves wrong.
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
  // nominal_ns: the stated period, to within kNominalRange; 0: not known.
  explicit GridSearch(double nominal_ns) noexcept : nominal_ns_(nominal_ns), next_pause_(kLongestStretch) {}

  // The next arrival, not before the last. Returns the grid if it is found now. An attempt takes about 100 µs.
  [[nodiscard]] std::optional<ArrivalGrid> add(std::int64_t arrival_ns) noexcept;
  // Of the grid just found: the first arrival of its stretch, from which ArrivalGrid::last_ns counts, and their number.
  [[nodiscard]] std::int64_t begin_ns() const noexcept { return stretch_[0]; }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }

  // Begins again with the next arrival, without a pause.
  void restart() noexcept { count_ = pause_ = 0; }

  // The stated period; 0: none, or it proved wrong.
  [[nodiscard]] double nominal_ns() const noexcept { return nominal_ns_; }
  void forget_nominal() noexcept { nominal_ns_ = 0.0; }

 private:
  static constexpr std::size_t kShortStretch = 64;  // arrivals: enough where jitter is small against the period
  // Arrivals skipped after a failure: kLongestStretch at first, doubled each time up to this, so that a source without
  // a rate costs nothing.
  static constexpr std::uint64_t kLongestPause = 65536;

  double nominal_ns_;
  std::array<std::int64_t, kLongestStretch> stretch_{};
  std::size_t count_ = 0;
  std::uint64_t pause_ = 0, next_pause_;  // arrivals still to skip; the pause after the next failure
};

}  // namespace dwell
