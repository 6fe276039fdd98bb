// Recovers the clock of a device that samples at its own constant rate, from the instants at which its readings reach
// the host.
//
//   a_j = t(k_j) + d_j,   t(k + 1) = t(k) + T
//
// The arrival a_j jitters, for the host is scheduled; t(k) does not. What is given out is t(k_j) plus the mean delay: a
// constant, so that phases of one stream keep, and the same constant that the arrivals themselves carry on average, so
// that nothing jumps when the clock is found amid a dwell. Why the mean and not the earliest arrivals: it is steady
// whatever the shape of the jitter, and it does not move when a busier host makes rare short delays rarer.
//
// GridSearch finds the grid among the first arrivals, ClockTracker follows it, LossJudge tells which reading an arrival
// is, and until that is decided HeldArrivals keeps it.
//
// Virtual time, no clock of its own; no allocation; bound to one thread. About 60 ns per arrival, now and then 100
// µs until a grid has been found.
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
  bool locked = false;         // false: no grid found (yet); stamps stand as they arrived, all else is NaN
  double rate_hz = kNaN;       // readings per second of the host's clock, those lost on the way included
  double jitter_s = kNaN;      // standard deviation of the arrivals from the recovered clock, stalls included
  std::uint64_t lost = 0;      // readings that never arrived, since the beginning
  std::uint64_t relocked = 0;  // times that the clock was lost and sought anew
};

class DeviceClock {
 public:
  static constexpr std::int64_t kLongestHold_ns = 100'000'000;   // a reading is decided upon after that
  static constexpr std::size_t kHeld = HeldArrivals::kCapacity;  // readings held at most
  static constexpr double kMemory_s = ClockTracker::kMemory_s;

  // nominal_rate_hz: what the device is set to, within 2 %; 0: not known.
  explicit DeviceClock(double nominal_rate_hz = 0.0) noexcept;

  // The next reading arrived. Take all that next() has before the next call.
  void arrive(std::int64_t arrival_ns) noexcept;
  // It is now_ns, and nothing has arrived since: nothing is held longer than kLongestHold_ns.
  void wait(std::int64_t now_ns) noexcept;
  // Decides on everything held, as the evidence stands.
  void decide_all() noexcept;

  // The instant of the oldest reading not yet given out, in the order of arrival.
  using Instant = DeviceInstant;
  // false: none is decided.
  bool next(Instant& out) noexcept { return held_.take(out); }

  [[nodiscard]] ClockFigures figures() const noexcept;

 private:
  void weigh(bool at_once) noexcept;
  void commit(std::size_t count) noexcept;
  void lock(const ArrivalGrid& grid) noexcept;
  void unlock() noexcept;

  HeldArrivals held_;
  GridSearch search_;
  ClockTracker tracker_;  // these three: while locked
  LossJudge judge_;
  ClockStamps stamps_;
  std::int64_t last_arrival_ns_ = 0;
  bool any_ = false, locked_ = false;
  std::uint64_t lost_ = 0, relocked_ = 0;
};

}  // namespace dwell
