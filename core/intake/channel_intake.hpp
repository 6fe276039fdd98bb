// The intake of one channel: every reading is judged by the readings around it before it counts.
//
// In this order: range and end codes, held registers, pile-up at an extreme, spikes, the motion of the readings before.
// Each has a file of its own, and there the false-alarm probability. Auxiliary channels pass all but the first.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#include "core/intake/device_numbers.hpp"
#include "core/intake/end_codes.hpp"
#include "core/intake/held_readings.hpp"
#include "core/intake/left_out.hpp"
#include "core/intake/motion_gate.hpp"
#include "core/intake/pile_up.hpp"
#include "core/intake/reading_times.hpp"
#include "core/intake/refresh_stamps.hpp"
#include "core/intake/rounding_step.hpp"
#include "core/intake/spike_gate.hpp"
#include "core/intake/value_cluster.hpp"
#include "core/result/condition.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Bound to one thread; judge() and what asks for numbers is real-time safe, what makes text allocates.
class ChannelIntake {
 public:
  using Reading = MotionGate::Reading;  // value: the device's own number
  using Says = MotionGate::Says;

  explicit ChannelIntake(const Channel& channel);

  // SI of the device's own number.
  [[nodiscard]] double si(double raw) const noexcept { return numbers_.si(raw); }

  // The next reading, finite and after the one before; ω of the drive, rad/s. give_back: waiting() first, then this.
  // A new value of a held register gets the instant of its refresh.
  Says judge(Reading& reading, double omega) noexcept;
  [[nodiscard]] std::span<const Reading> waiting() const noexcept { return motion_.waiting(); }

  // Readings left out, of all time.
  [[nodiscard]] std::uint64_t left() const noexcept { return left_.of_all_time() + motion_.foreign().of_all_time(); }

  void next_period() noexcept { spikes_.next_period(); }
  // Standard deviation of what a fit of harmonics left over in the newest period, SI. What prediction by the readings
  // before is off by holds the harmonics as well, where there are few readings a period.
  void see_residuals(double sigma) noexcept;
  // The drive is steady from now on: what is counted, is counted anew.
  void begin_hold() noexcept;
  // The data count from about now on: what the gate took for foreign while the transient was large is said no more.
  void begin_to_count() noexcept;

  [[nodiscard]] bool overrange() const noexcept { return overrange_now_; }
  // One and the same reading for longer than allowed.
  [[nodiscard]] double same_for_s() const noexcept { return times_.same_for_s(); }
  // The device's rounding step, SI. INFINITY: no two readings have differed; 0: there is none.
  [[nodiscard]] double step() const noexcept { return numbers_.si_of_difference(rounding_.step()); }
  [[nodiscard]] bool clipped() const noexcept { return clipped_above() + clipped_below() > 0; }
  // Relative loss of the fundamental's amplitude by clipping; 0: none. If the part p of all readings is clipped, the
  // loss is (2/3π) (πp)³.
  [[nodiscard]] double clipping_bias() const noexcept;
  // The register is refreshed more slowly than it is read, so that each new value is used once: half width to which the
  // instants of the refreshes are known, mean of this hold, s; 0: it is not held.
  [[nodiscard]] double refresh_half_s() const noexcept { return held() ? stamps_.half_s() : 0.0; }
  [[nodiscard]] bool held() const noexcept { return held_.held(); }
  // The register began or ceased to be held after this hold began, so its data are of both kinds.
  [[nodiscard]] bool holding_changed() const noexcept { return held_.held() != held_at_begin_; }
  // Relative error of the phasor by readings that are older ones again and count: each lags by as much as it is old. 0:
  // there are none. With few readings a period a motion of many harmonics turns as such readings do: then 0.
  [[nodiscard]] double repeat_bias() const noexcept;
  [[nodiscard]] std::string repeat_reason() const;
  // One number is among the readings far too often.
  [[nodiscard]] bool clustered() const noexcept { return cluster_.found(rounding_.step()); }
  [[nodiscard]] std::string clustered_reason() const;
  // Part of the readings of this hold that were left out as foreign or beyond the range.
  [[nodiscard]] double left_out() const noexcept;

  // Whether what was left out says something of the device: far spikes, numbers beyond the range, or more than the gate
  // takes of good readings.
  [[nodiscard]] bool left_out_matters() const noexcept;

  [[nodiscard]] Condition condition() const noexcept;
  // In words, with figures.
  [[nodiscard]] std::string held_reason() const;
  [[nodiscard]] std::string clipped_reason() const;
  [[nodiscard]] std::string left_out_reason() const;
  [[nodiscard]] std::string condition_reason() const;

 private:
  [[nodiscard]] double apart() const noexcept;
  [[nodiscard]] HeldReadings::Again again() const noexcept;
  [[nodiscard]] PileUp::Noise noise() const noexcept;
  [[nodiscard]] bool frozen() const noexcept;
  // Of the drive; 0: not known.
  [[nodiscard]] double readings_a_period() const noexcept;
  [[nodiscard]] std::int64_t clipped_above() const noexcept { return pile_up_.above(noise()); }
  [[nodiscard]] std::int64_t clipped_below() const noexcept { return pile_up_.below(noise()); }
  Says count(const Reading& reading, std::int64_t read_ns, Says says) noexcept;

  DeviceNumbers numbers_;
  bool judged_;  // not auxiliary
  EndCodes codes_;
  HeldReadings held_;
  RefreshStamps stamps_;
  PileUp pile_up_;
  ValueCluster cluster_;
  SpikeGate spikes_;
  MotionGate motion_;
  RoundingStep rounding_;
  ReadingTimes times_;
  LeftOut left_;

  double newest_taken_ = NAN;
  struct {
    double omega = 0.0;                   // of the drive, rad/s
    ReadingTimes::MeanInterval interval;  // of the readings
  } sampled_;                             // as the newest reading was judged
  double residuals2_ = INFINITY;  // of this hold: variance, the newest period an eighth of it, the device's numbers
  bool overrange_now_ = false, held_at_begin_ = false;
  bool stuck_ = false;  // the newest reading is identical to so many before it as no motion explains
};

}  // namespace dwell
