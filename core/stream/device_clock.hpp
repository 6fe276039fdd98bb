// Recovers the clock of a device that samples at its own constant rate, from the instants at which its readings reach
// the host.
//
//   a_j = t(k_j) + d_j,   t(k + 1) = t(k) + T
//
// The arrival a_j jitters because the host schedules; t(k) does not. The clock gives out t(k_j) plus the mean delay.
// That constant keeps the phases within one stream. The arrivals carry the same constant on average, so no stamp jumps
// when the clock is found during a dwell. The mean is steady for every shape of jitter. The earliest arrivals are not:
// a busier host makes short delays rarer.
//
// GridSearch finds the grid among the first arrivals and ClockTracker follows it. LossJudge decides which reading an
// arrival is; until then HeldArrivals keeps it. ClockStamps makes the stamps.
//
// Virtual time, no allocation; bound to one thread. About 60 ns per arrival; an attempt to find the grid takes 100 µs.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/result/dwell.hpp"
#include "core/stream/clock_stamps.hpp"
#include "core/stream/clock_tracker.hpp"
#include "core/stream/grid_search.hpp"
#include "core/stream/held_arrivals.hpp"
#include "core/stream/loss_judge.hpp"

namespace dwell {

// What is known of a device's clock.
struct ClockFigures {
  bool locked = false;         // false: no grid found (yet); stamps are the arrivals, the rate and jitter NaN
  double rate_hz = kNaN;       // readings per second of the host's clock, lost ones included
  double jitter_s = kNaN;      // standard deviation of the arrivals from the recovered clock, stalls included
  std::uint64_t lost = 0;      // readings that never arrived, since construction
  std::uint64_t relocked = 0;  // how often the clock was lost and sought again
};

class DeviceClock {
 public:
  static constexpr std::int64_t kLongestHold_ns = 100'000'000;  // then a reading is decided

  // nominal_rate_hz: the rate set in the device, to within kNominalRange; 0: not known. A wrong rate delays the search.
  explicit DeviceClock(double nominal_rate_hz = 0.0) noexcept;

  // The next reading arrived. Take all instants that next() has before the next call.
  void arrive(std::int64_t arrival_ns) noexcept;
  // It is now_ns, and nothing has arrived since. A reading held for longer than kLongestHold_ns is decided.
  void wait(std::int64_t now_ns) noexcept;
  // Decides all readings held, on the evidence so far.
  void decide_all() noexcept;

  using Instant = DeviceInstant;
  // Takes the instant of the oldest decided reading; false: none is decided.
  bool next(Instant& out) noexcept { return held_.take(out); }

  [[nodiscard]] ClockFigures figures() const noexcept;

 private:
  void weigh(bool at_once) noexcept;
  void commit(std::size_t count) noexcept;
  void lock(const ArrivalGrid& grid) noexcept;
  void unlock() noexcept;

  HeldArrivals held_;
  GridSearch search_;
  ClockTracker tracker_;  // these three: valid while locked
  LossJudge judge_;
  ClockStamps stamps_;
  std::int64_t last_arrival_ns_ = 0;
  bool any_ = false, locked_ = false;
  std::uint64_t lost_ = 0, relocked_ = 0;
};

}  // namespace dwell
