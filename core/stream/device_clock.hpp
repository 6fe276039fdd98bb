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
// T and t are followed by a second-order tracker with the gains of least squares that grow older: first those of a line
// through all that has come, later those of a memory of kMemory_s. Arrivals far off (stalls) do not enter.
//
// Which reading an arrival is: the next, unless it is later than the earliest that the one after could be. Then it is
// either late or follows a loss, and it and those after it are held until one of them shows that nothing was lost (it
// is as early as only the next reading can be), or as many have come without such that a loss is beyond doubt.
//
// Virtual time, no clock of its own; no allocation; bound to one thread. About 60 ns per arrival, now and then 100
// µs until a grid has been found.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/result/dwell.hpp"
#include "core/stream/arrival_grid.hpp"

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
  static constexpr std::int64_t kLongestHold_ns = 100'000'000;  // a reading is decided upon after that
  static constexpr std::size_t kHeld = 256;                     // readings held at most
  static constexpr double kMemory_s = 20.0;

  // nominal_rate_hz: what the device is set to, within 2 %; 0: not known.
  explicit DeviceClock(double nominal_rate_hz = 0.0) noexcept;

  // The next reading arrived. Take all that next() has before the next call.
  void arrive(std::int64_t arrival_ns) noexcept;
  // It is now_ns, and nothing has arrived since: nothing is held longer than kLongestHold_ns.
  void wait(std::int64_t now_ns) noexcept;
  // Decides on everything held, as the evidence stands.
  void decide_all() noexcept;

  // The instant of the oldest reading not yet given out, in the order of arrival.
  struct Instant {
    std::int64_t t_ns = 0;      // locked: after the one before, always
    std::uint32_t half_ns = 0;  // half width of what the recovery is uncertain by; 0 where the arrival stands
    bool after_loss = false;    // readings before it never arrived
  };
  // false: none is decided.
  bool next(Instant& out) noexcept;

  [[nodiscard]] ClockFigures figures() const noexcept;

 private:
  struct Held {
    std::int64_t arrival_ns = 0;
    Instant instant;
  };
  [[nodiscard]] Held& held(std::size_t i) noexcept { return ring_[(first_ + i) % kHeld]; }
  [[nodiscard]] std::size_t waiting() const noexcept { return count_ - decided_; }
  struct Verdict {
    std::size_t settled = 0;  // so many of those waiting follow each other without a loss
    int lost = 0;             // readings lost after them; negative: so many too many were counted
  };
  // Of the i-th reading waiting, in periods, if nothing was lost.
  [[nodiscard]] double deviation(std::size_t i) noexcept;

  void weigh(bool at_once) noexcept;
  [[nodiscard]] Verdict judge(bool at_once) noexcept;
  void commit(std::size_t count) noexcept;
  void commit_one(Held& reading) noexcept;
  void shift(double periods) noexcept;
  void acquire(std::int64_t arrival_ns) noexcept;
  void lock(const ArrivalGrid& grid, std::size_t count) noexcept;
  void unlock() noexcept;

  double nominal_ns_;

  std::array<Held, kHeld> ring_{};  // first_: the oldest; the first decided_ of count_ have their instant
  std::size_t first_ = 0, decided_ = 0, count_ = 0;
  std::int64_t last_arrival_ns_ = 0;
  bool any_ = false;

  // Until locked.
  std::array<std::int64_t, kLongestStretch> stretch_{};
  std::size_t stretch_count_ = 0;
  std::uint64_t pause_ = 0, next_pause_;

  // Locked: the last reading decided on was at whole_ns_ + part_ns_.
  bool locked_ = false;
  std::int64_t whole_ns_ = 0;
  double part_ns_ = 0.0;
  double period_ns_ = 0.0;
  double memory_ = 0.0;  // readings: kMemory_s
  double age_ = 0.0;     // readings since the grid began, at most 3 memories
  double spread_ = 0.0;  // see ArrivalGrid
  DelayShape shape_;
  std::int64_t previous_arrival_ns_ = 0;  // of the last reading decided on
  double variance_ = 0.0;                 // of the deviations, stalls included, periods²
  double lost_part_ = 0.0;                // of the readings, recently
  double too_early_ = 0.0;                // numbers taken back beyond the losses counted before, recently
  double mistrusted_ = 0.0;               // part of the readings, recently, at which the rate would have left its range
  double doubt_ = 0.0;                    // periods by which the numbering was just put right
  bool after_loss_ = false;
  std::int64_t last_given_ns_ = 0;

  std::uint64_t lost_ = 0, relocked_ = 0;
};

}  // namespace dwell
