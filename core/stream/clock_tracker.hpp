// Follows a device's clock once its grid is known: the instant t of its newest reading and its period T.
//
// A second-order tracker with the gains of least squares that grow older: first those of a line through all that has
// come, later those of a memory of kMemory_s. Arrivals far off (stalls) do not enter.
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

  // Begins on a grid found among `count` arrivals from begin_ns on. nominal_ns: the stated period, which is not left by
  // more than kNominalRange; 0: not known.
  void begin(const ArrivalGrid& grid, std::int64_t begin_ns, std::size_t count, double nominal_ns) noexcept;

  // How late an arrival is for the reading `ahead` after the newest, in periods; delays at their mean are 0.
  [[nodiscard]] double deviation(std::int64_t arrival_ns, std::size_t ahead) const noexcept {
    const double since_ns = static_cast<double>(arrival_ns - whole_ns_) - part_ns_;
    return since_ns / period_ns_ - static_cast<double>(ahead);
  }
  // The next reading arrived then. Returns how late that was, in periods.
  double follow(std::int64_t arrival_ns) noexcept;
  // So many readings never arrived; negative: so many were counted too many.
  void shift(double readings) noexcept { part_ns_ += readings * period_ns_; }

  // Instant of the newest reading, ns; it is known to ± half_ns().
  [[nodiscard]] std::int64_t t_ns() const noexcept { return whole_ns_ + (part_ns_ >= 0.5 ? 1 : 0); }
  [[nodiscard]] double half_ns() const noexcept;

  [[nodiscard]] double period_ns() const noexcept { return period_ns_; }
  // Standard deviation of the arrivals from the clock, ns, stalls included.
  [[nodiscard]] double jitter_ns() const noexcept;
  // Too often the arrivals would have drawn the period out of the range of the stated one.
  [[nodiscard]] bool doubts_nominal() const noexcept { return mistrusted_ > kMostMistrusted; }

 private:
  static constexpr double kMostMistrusted = 0.4;

  std::int64_t whole_ns_ = 0;  // the newest reading was at whole_ns_ + part_ns_
  double part_ns_ = 0.0;
  double period_ns_ = 0.0, nominal_ns_ = 0.0;
  double memory_ = 0.0;      // readings: kMemory_s
  double age_ = 0.0;         // readings since the grid began, at most 3 memories
  double spread_ = 0.0;      // see ArrivalGrid
  double variance_ = 0.0;    // of the deviations, stalls included, periods²
  double mistrusted_ = 0.0;  // part of the readings, recently, at which the rate would have left its range
};

}  // namespace dwell
