// The drive's frequency and phase from the sync input: one pulse for each of its periods, at phase zero.
//
// Pulse k comes at t_k = t_0 + k T. Which k a pulse has is decided as it comes: it must lie near a whole number of
// periods after those before it, so a pulse that failed to come leaves a hole in k, and one that comes twice, or stray,
// has none. T and its uncertainty are those of the straight line through the pulses of a stretch, from the residuals
// about it: those of single pulses, or those of the means of their runs where these lie further off than independent
// jitter explains. Pulses that no longer fit to those before but to each other begin
// a new train, whose k have nothing to do with the former's.
//
// Pulses are kept as moments of runs of neighbours, the longer the older they are, so that a fixed number of runs holds
// any train.
// Bound to one thread; real-time safe but for the constructor.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/angle.hpp"

namespace dwell {

// What a stretch of pulses says of the drive.
struct PulseLine {
  double omega = 0.0;         // rad/s
  double u = 0.0;             // its standard uncertainty, rad/s; NaN: too few pulses to tell
  std::int64_t pulse_ns = 0;  // an instant of phase zero, as the line has it
  double span_s = 0.0;        // from the first pulse to the last

  // The instant of phase zero nearest to t.
  [[nodiscard]] std::int64_t nearest_ns(std::int64_t t_ns) const noexcept;
};

class SyncReference {
 public:
  struct Counts {
    std::uint64_t pulses = 0;  // that have a k
    std::uint64_t missed = 0;  // that should have come between those
    std::uint64_t extra = 0;   // that have none: double or stray
  };

  // low_hz, high_hz: between which the drive is looked for.
  SyncReference(double low_hz, double high_hz);

  // The next pulse; instants do not decrease.
  void pulse(std::int64_t t_ns) noexcept;

  // Angular frequency by the newest pulses, rad/s; NaN: no train.
  [[nodiscard]] double omega() const noexcept {
    return train_.number != 0 ? kTwoPi / T_s_ : std::numeric_limits<double>::quiet_NaN();
  }
  // A train goes on at t: its newest pulse is less than kLostPeriods old (and kLost_s).
  [[nodiscard]] bool present(std::int64_t t_ns) const noexcept;
  // The line through the pulses of [from, to], by the train that has most of them there; none with fewer than
  // kFewest. O(runs).
  [[nodiscard]] std::optional<PulseLine> over(std::int64_t from_ns, std::int64_t to_ns) const noexcept;
  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }
  // The newest pulse that has a k; INT64_MIN: none yet.
  [[nodiscard]] std::int64_t newest_ns() const noexcept { return newest_ns_; }

  static constexpr double kLostPeriods = 8.0;
  static constexpr double kLost_s = 1.0;
  static constexpr int kFewest = 6;

 private:
  static constexpr std::size_t kRecent = 16;  // pulses that foretell the next
  static constexpr std::size_t kBegin = 4;    // pulses in step that begin a train
  static constexpr double kFarthest = 16.0;   // periods that may be missing within a train: more are not counted surely
  static constexpr std::size_t kRuns = 512;
  static constexpr std::size_t kPerLength = 16;  // runs of one length kept before two of them are joined

  // x = t - begin_ns - k · T_s is what lies in a train beyond its first guess.
  struct Train {
    std::uint64_t number = 0;  // 0: none
    std::int64_t begin_ns = 0;
    double T_s = 0.0;
  };
  // Pulses of one train one after the other: count, means of k and x, sums of squares and products about these (x in
  // s).
  struct Run {
    Train train;
    std::int64_t first_ns, last_ns;
    double n, k, x, kk, kx, xx;
  };

  void begin_train() noexcept;
  void accept(std::int64_t t_ns, std::int64_t k) noexcept;
  void foretell() noexcept;
  void keep(std::int64_t t_ns, std::int64_t k) noexcept;
  static void join(Run& into, const Run& other) noexcept;
  template <class Take>
  void each_run(std::int64_t from_ns, std::int64_t to_ns, Take&& take) const noexcept;

  double shortest_s_, longest_s_;  // intervals that can be a period
  Counts counts_;
  Train train_;
  std::uint64_t trains_ = 0;
  std::int64_t newest_ns_ = INT64_MIN, newest_k_ = 0;
  struct Recent {
    std::int64_t t_ns, k;
  };
  std::array<Recent, kRecent> recent_{};
  std::size_t recents_ = 0;                     // pulses of the train so far
  double T_s_ = 0.0, spread_s_ = 0.0;           // of the recent ones: their line's period, and how they lie about it
  double due_s_ = 0.0;                          // where that line has pulse newest_k_, from newest_ns_
  std::array<std::int64_t, kBegin> waiting_{};  // that fit nothing yet
  std::size_t waits_ = 0;
  std::vector<Run> runs_;  // oldest first
};

}  // namespace dwell
