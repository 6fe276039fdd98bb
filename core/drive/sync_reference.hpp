// Finds the drive's frequency and phase from the sync input: one pulse per period of the drive, at phase zero.
//
// Pulse k comes at t_k = t_0 + k T. A pulse gets its k on arrival: it must lie near a whole number of periods after the
// pulses before. A missed pulse leaves a gap in k; a double or stray pulse gets no k. NextPulse predicts where a pulse
// of the train may lie. Pulses that fit each other but not the train begin a new one (TrainBegin), with a numbering
// of its own. PulseRuns keeps the pulses and fits the line through a stretch. Bound to one thread; real-time safe
// except for the constructor.
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
    std::uint64_t missed = 0;  // whose k is missing between those
    std::uint64_t extra = 0;   // that have no k: double or stray
  };

  // low_hz, high_hz: the range in which the drive is searched.
  SyncReference(double low_hz, double high_hz);

  // Takes the next pulse; instants must not decrease.
  void pulse(std::int64_t t_ns) noexcept;

  // Angular frequency by the newest pulses, rad/s; NaN: no train.
  [[nodiscard]] double omega() const noexcept {
    return train_.number != 0 ? kTwoPi / next_.T_s() : std::numeric_limits<double>::quiet_NaN();
  }
  // Whether a train goes on at t: its newest pulse is no older than kSilent_s or kLostPeriods, whichever is longer.
  [[nodiscard]] bool present(std::int64_t t_ns) const noexcept;
  // The line through the pulses of [from, to], see PulseRuns::over(). None with fewer than PulseRuns::kFewest. O(runs).
  [[nodiscard]] std::optional<PulseLine> over(std::int64_t from_ns, std::int64_t to_ns) const noexcept {
    return runs_.over(from_ns, to_ns);
  }
  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }
  // The newest pulse that has a k; INT64_MIN: none yet.
  [[nodiscard]] std::int64_t newest_ns() const noexcept { return next_.newest_ns(); }

  static constexpr double kLostPeriods = 8.0;

 private:
  static constexpr double kFarthest = 16.0;  // periods between pulses of a train: more cannot be counted with certainty

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
