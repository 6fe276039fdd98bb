// Follows a device's clock once its grid is known: the instant t of its newest reading and its period T.
//
// A second-order tracker. Its gains are at first those of a least-squares line through all arrivals, later those of a
// fading memory of kMemory_s. Arrivals far from the prediction (stalls) do not move the clock.
//
// Fixed storage, no allocation. Bound to one thread; real-time safe.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/stream/arrival_grid.hpp"

namespace dwell {

class ClockTracker {
 public:
  static constexpr double kMemory_s = 20.0;

  // Begins on a grid found among `count` arrivals from begin_ns on. nominal_ns: the stated period; 0: not known. The
  // tracked period stays within kNominalRange of it.
  void begin(const ArrivalGrid& grid, std::int64_t begin_ns, std::size_t count, double nominal_ns) noexcept;

  // How late an arrival is, in periods, if it is the reading `ahead` after the newest. The mean delay counts as 0.
  [[nodiscard]] double deviation(std::int64_t arrival_ns, std::size_t ahead) const noexcept {
    const double since_ns = static_cast<double>(arrival_ns - whole_ns_) - part_ns_;
    return since_ns / period_ns_ - static_cast<double>(ahead);
  }
  // The next reading arrived at arrival_ns. Returns how late it was, in periods.
  double follow(std::int64_t arrival_ns) noexcept;
  // So many readings never arrived; negative: so many were counted that do not exist.
  void shift(double readings) noexcept { part_ns_ += readings * period_ns_; }

  // Instant of the newest reading, ns, known to ± half_ns().
  [[nodiscard]] std::int64_t t_ns() const noexcept { return whole_ns_ + (part_ns_ >= 0.5 ? 1 : 0); }
  [[nodiscard]] double half_ns() const noexcept;

  [[nodiscard]] double period_ns() const noexcept { return period_ns_; }
  // Standard deviation of the arrivals from the clock, ns, stalls included.
  [[nodiscard]] double jitter_ns() const noexcept;
  // Whether the arrivals contradict the stated period: in more than kMostMistrusted of the recent readings they would
  // have moved the tracked one out of its range.
  [[nodiscard]] bool doubts_nominal() const noexcept { return mistrusted_ > kMostMistrusted; }

 private:
  static constexpr double kMostMistrusted = 0.4;

  std::int64_t whole_ns_ = 0;  // the newest reading was at whole_ns_ + part_ns_
  double part_ns_ = 0.0;
  double period_ns_ = 0.0, nominal_ns_ = 0.0;
  double memory_ = 0.0;      // kMemory_s in readings, at least 32
  double age_ = 0.0;         // readings since the grid began, at most 3 memories
  double spread_ = 0.0;      // see ArrivalGrid
  double variance_ = 0.0;    // of the deviations, stalls included, periods²
  double mistrusted_ = 0.0;  // part of the recent readings at which the tracked period would have left its range
};

}  // namespace dwell
