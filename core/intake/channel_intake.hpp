// Judges every reading of one channel by the readings around it, before it counts.
//
// The order: range and end codes, held registers, pile-up at an extreme, spikes, the motion of the readings before.
// Each has its own file, which gives the false-alarm probability. Auxiliary channels pass all but the first.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/intake/device_numbers.hpp"
#include "core/intake/end_codes.hpp"
#include "core/intake/held_readings.hpp"
#include "core/intake/left_out.hpp"
#include "core/intake/motion_gate.hpp"
#include "core/intake/pile_up.hpp"
#include "core/intake/plain_run.hpp"
#include "core/intake/reading_times.hpp"
#include "core/intake/refresh_stamps.hpp"
#include "core/intake/rounding_step.hpp"
#include "core/intake/spike_gate.hpp"
#include "core/intake/value_cluster.hpp"
#include "core/result/condition.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Bound to one thread; judge() and numbers are real-time safe, functions that return text allocate.
class ChannelIntake {
 public:
  using Reading = MotionGate::Reading;  // value: the device's own number
  using Says = MotionGate::Says;

  explicit ChannelIntake(const Channel& channel);

  // The device's own number in SI.
  [[nodiscard]] double si(double raw) const noexcept { return numbers_.si(raw); }

  // Judges the next reading: finite, and after the one before. omega: of the drive, rad/s. give_back: take waiting()
  // first, then this reading. A new value of a held register gets the instant of its refresh.
  Says judge(Reading& reading, double omega) noexcept;
  // Begins a run of plain readings after the newest one, or closes it: the next reading cannot be plain.
  void begin(PlainRun& run, double omega) const noexcept;
  // Judges the first readings of a run begun since the newest judge() or take_plain(): those that judge() would take as
  // they are. Shortens the run to them.
  void take_plain(PlainRun& run, double omega) noexcept;
  [[nodiscard]] std::span<const Reading> waiting() const noexcept { return motion_.waiting(); }

  // Readings left out since construction.
  [[nodiscard]] std::uint64_t left() const noexcept {
    return left_.of_all_time() + motion_.foreign().of_all_time() + motion_.uncertain();
  }

  void next_period() noexcept {
    spikes_.next_period();
    if (judged_) pile_up_.next_period(noise());
  }
  // Standard deviation of the residuals of the harmonic fit over the newest period, SI. With few readings a period the
  // gate's prediction errors contain the harmonics; these residuals do not.
  void see_residuals(double sigma) noexcept;
  // The drive is steady from now on: all counts begin anew.
  void begin_hold() noexcept;
  // The data count from about now on. Readings that the gates left out before, while the transient was large, are no
  // longer reported.
  void begin_to_count() noexcept;

  [[nodiscard]] bool overrange() const noexcept { return overrange_now_; }
  // Whether the newest reading equals the one before.
  [[nodiscard]] bool repeats() const noexcept { return times_.repeats(); }
  // How long the equal readings lasted if each lasted a mean interval, s.
  [[nodiscard]] double read_same_s() const noexcept { return times_.read_same_s(); }
  // For how long the reading has been one and the same.
  [[nodiscard]] double same_for_s() const noexcept { return times_.same_for_s(); }
  // The device's rounding step, SI. INFINITY: no two readings have differed; 0: there is none.
  [[nodiscard]] double step() const noexcept { return numbers_.si_of_difference(rounding_.step()); }
  [[nodiscard]] bool clipped() const noexcept { return clipped_above() + clipped_below() > 0; }
  // Loss of the fundamental's amplitude by clipping, relative; 0: none (PileUp::loss).
  [[nodiscard]] double clipping_bias() const noexcept;
  // A warning, with figures, where rounding may hide a clipping that costs more of the amplitude than a model can bear;
  // else empty. Only for a channel whose noise does not smooth the rounding. Allocates.
  [[nodiscard]] std::string coarse_reason() const;
  // For a held register: mean half width of the refreshes' instants in this hold, s; 0: it is not held. The device
  // refreshes such a register more slowly than it is read, and each new value is used once.
  [[nodiscard]] double refresh_half_s() const noexcept { return held() ? stamps_.half_s() : 0.0; }
  // The largest of these half widths: so much the instants may drift in this hold, either way.
  [[nodiscard]] double widest_refresh_half_s() const noexcept { return held() ? stamps_.widest_s() : 0.0; }
  [[nodiscard]] bool held() const noexcept { return held_.held(); }
  // The register began or ceased to be held after this hold began: its data are of both kinds.
  [[nodiscard]] bool holding_changed() const noexcept { return held_.held() != held_at_begin_; }
  // Relative error of the phasor by repeats of older readings that count: each is late by its age. 0: none; or too few
  // readings a period, where a motion of many harmonics looks like such repeats.
  [[nodiscard]] double repeat_bias() const noexcept;
  [[nodiscard]] std::string repeat_reason() const;
  // One number makes up far too many of the readings.
  [[nodiscard]] bool clustered() const noexcept { return cluster_.found(rounding_.step()); }
  [[nodiscard]] std::string clustered_reason() const;
  // Part of this hold's readings that were left out as foreign, as spikes or beyond the range.
  [[nodiscard]] double left_out() const noexcept;
  // The answer was held up on its way: the half width of its instant is beyond 1.5 times the running median.
  [[nodiscard]] bool held_up(const Reading& reading) const noexcept { return motion_.held_up(reading); }
  // Part of this hold's readings that were answered too late to count.
  [[nodiscard]] double late() const noexcept;

  // Whether the readings left out show a fault of the device: far spikes, numbers beyond the range, or more of them
  // than the gate leaves out of good readings.
  [[nodiscard]] bool left_out_matters() const noexcept;

  [[nodiscard]] Condition condition() const noexcept;
  // In words, with figures.
  [[nodiscard]] std::string held_reason() const;
  [[nodiscard]] std::string clipped_reason() const;
  [[nodiscard]] std::string left_out_reason() const;
  [[nodiscard]] std::string condition_reason() const;

 private:
  [[nodiscard]] double apart() const noexcept;
  // Number of readings, from the run's first on, that pass every check of a plain reading. The motion gate's is not
  // among these checks.
  [[nodiscard]] std::size_t plain_ones(const PlainRun& run) const noexcept;
  [[nodiscard]] HeldReadings::Again again() const noexcept;
  [[nodiscard]] PileUp::Noise noise() const noexcept;
  [[nodiscard]] bool frozen() const noexcept;
  // Readings in a period of the drive; 0: not known.
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
  } sampled_;                             // when the newest reading was judged
  // Variance of the residuals in this hold, mean over about eight periods, the device's numbers squared.
  double residuals2_ = INFINITY;
  bool overrange_now_ = false, held_at_begin_ = false;
  bool stuck_ = false;  // the newest reading belongs to a run that no motion explains
};

}  // namespace dwell
