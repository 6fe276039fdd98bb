// The drive's frequency and phase from the sync input: one pulse for each of its periods, at phase zero.
//
// Pulse k comes at t_k = t_0 + k T. Which k a pulse has is decided as it comes: it must lie near a whole number of
// periods after those before it, so a pulse that failed to come leaves a hole in k, and one that comes twice, or stray,
// has none. NextPulse says where a pulse of the train may lie. Pulses that no longer fit to those before but to each
// other begin a new train (TrainBegin), whose k have nothing to do with the former's. PulseRuns keeps the pulses and
// gives the line through those of a stretch.
// Bound to one thread; real-time safe but for the constructor.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "core/base/angle.hpp"
#include "core/drive/next_pulse.hpp"
#include "core/drive/pulse_runs.hpp"
#include "core/drive/train_begin.hpp"

namespace dwell {

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
    return train_.number != 0 ? kTwoPi / next_.T_s() : std::numeric_limits<double>::quiet_NaN();
  }
  // A train goes on at t: its newest pulse is less than kLostPeriods old (and kLost_s).
  [[nodiscard]] bool present(std::int64_t t_ns) const noexcept;
  // The line through the pulses of [from, to], by the train that has most of them there; none with fewer than
  // kFewest. O(runs).
  [[nodiscard]] std::optional<PulseLine> over(std::int64_t from_ns, std::int64_t to_ns) const noexcept {
    return runs_.over(from_ns, to_ns);
  }
  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }
  // The newest pulse that has a k; INT64_MIN: none yet.
  [[nodiscard]] std::int64_t newest_ns() const noexcept { return next_.newest_ns(); }

  static constexpr double kLostPeriods = 8.0;
  static constexpr double kLost_s = 1.0;
  static constexpr int kFewest = PulseRuns::kFewest;

 private:
  static constexpr double kFarthest = 16.0;  // periods that may be missing within a train: more are not counted surely

  void begin_train(double period_s) noexcept;
  void accept(std::int64_t t_ns, std::int64_t k) noexcept;

  Counts counts_;
  PulseTrain train_;          // number 0: none goes on
  std::uint64_t trains_ = 0;  // so far
  NextPulse next_;
  TrainBegin strays_;
  PulseRuns runs_;
};

}  // namespace dwell
