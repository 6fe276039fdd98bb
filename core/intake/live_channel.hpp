// One channel as it delivers: counts every sample, lets the intake judge it before it counts, and tells whether the
// channel delivers, is stuck, or is unfit for a verdict.
//
// The figures of a dwell (how late its readings were, how often new values came) begin anew with each hold.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/instants.hpp"
#include "core/fit/mains.hpp"
#include "core/intake/channel_intake.hpp"
#include "core/intake/channel_now.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"

namespace dwell {

// Bound to one thread; real-time safe except for the constructor and functions that return text.
class LiveChannel {
 public:
  using Reading = ChannelIntake::Reading;

  explicit LiveChannel(const Channel& channel) : intake_(channel) {}

  // A sample that does not fit the stream's order: counted, not used.
  void refuse() noexcept { ++received_, ++out_of_order_; }
  // The device reports that the channel does not deliver, or (Fault::none) that it does again.
  void tell(Fault fault) noexcept { now_.fault = fault; }

  // Takes in the next sample of the stream before it is judged. false: not finite, or not after the one before; it is
  // counted, not used.
  [[nodiscard]] bool hear(const Record& record) noexcept;
  // Judges the sample just heard; omega_rad_s: of the drive. take(const Reading&) gets the readings that pass now, the
  // oldest first: those that had to wait, then this one.
  template <class Take>
  void judge(const Record& record, double omega_rad_s, Take&& take) {
    Reading reading{record.t_ns, record.value, record.t_half_ns};
    const ChannelIntake::Says says = intake_.judge(reading, omega_rad_s);
    show(record);
    if (says != ChannelIntake::Says::take && says != ChannelIntake::Says::give_back) return;
    for (const Reading& waited : intake_.waiting()) take(waited);
    take(reading);
  }
  // Begins a run of plain readings (ChannelIntake::begin); closes it for a channel of which no reading has counted yet.
  void begin(PlainRun& run, double omega_rad_s) const noexcept {
    intake_.begin(run, omega_rad_s);
    if (!has_counted() || run.before_ns() != last_ns_) run.close();
  }
  // Hears and judges the first readings of the run, those that are plain; all of them pass. Shortens the run to them.
  void take_plain(PlainRun& run, double omega_rad_s) noexcept;
  // A reading that has passed and counts. Returns its value, SI.
  double count(const Reading& reading) noexcept;
  // A reading that has passed while the channel is stuck: not used.
  void leave_out_stuck() noexcept { ++stuck_; }
  // Whether a reading of this channel has ever counted.
  [[nodiscard]] bool has_counted() const noexcept { return refreshed_ns_ != INT64_MIN; }
  // By how much the half width of this reading's instant exceeds 1.5 times this hold's mean, s; 0: not held up.
  [[nodiscard]] double extra_u_s(const Reading& reading) const noexcept;

  // The drive is steady from now on.
  void begin_hold() noexcept;
  // The data count from now on.
  void begin_to_count() noexcept { intake_.begin_to_count(); }
  void next_period() noexcept { intake_.next_period(); }
  void see_residuals(double sigma) noexcept { intake_.see_residuals(sigma); }

  // The reading has been one and the same for longer than a motion of this period allows.
  [[nodiscard]] bool stuck(double period_s) const noexcept;
  // No fault is known, and the newest sample is recent: within two periods, or 1 s.
  [[nodiscard]] bool delivers(std::int64_t now_ns, double period_s) const noexcept;
  // Its readings do not show the motion: stuck, clipped, clustered or mostly left out. tolerance: Rig::tolerance.
  [[nodiscard]] bool unfit(double period_s, double tolerance) const noexcept;

  [[nodiscard]] const ChannelIntake& intake() const noexcept { return intake_; }
  // How regularly its values come; for a held register, its refreshes.
  [[nodiscard]] const SamplingRegularity& sampling() const noexcept { return sampling_; }
  // The newest sample's value, SI; NaN: none yet.
  [[nodiscard]] double value() const noexcept { return now_.value; }
  [[nodiscard]] ChannelNow now(double period_s) const noexcept;
  // Standard uncertainty of the instants of this hold's readings by the device's turnaround, s.
  [[nodiscard]] double turnaround_u_s() const noexcept;

  // The condition in words, with figures; empty: ok. Allocates.
  [[nodiscard]] std::string condition_reason(double period_s) const;
  // Why the channel does not deliver. Only for one that does not.
  [[nodiscard]] std::string silent_reason() const;
  // The fault in short: "timeout"; "silent" where none is known.
  [[nodiscard]] const char* fault_name() const noexcept;
  // Why its phasor must not be used; empty: it may. amplitude, u: of the reading's phasor and its standard uncertainty,
  // SI. measuring: a dwell is being measured.
  [[nodiscard]] std::string unfit_reason(double amplitude, double u, bool measuring) const;
  // Warnings for a dwell that uses its readings, each without the channel's name.
  [[nodiscard]] std::vector<std::string> warnings(double tolerance) const;

 private:
  static constexpr double kLostPeriods = 2.0;  // without a sample, and at least 1 s: the channel no longer delivers
  static constexpr double kStuck_s = 0.5;      // and at least kLostPeriods with the same reading: it is stuck

  void show(const Record& record) noexcept;

  ChannelIntake intake_;
  ChannelNow now_;
  std::uint64_t received_ = 0, out_of_order_ = 0, stuck_ = 0;  // the latter two: not used
  std::int64_t last_ns_ = INT64_MIN;
  std::int64_t refreshed_ns_ = INT64_MIN;        // of the newest reading that counted
  double half_ns_sum_ = 0.0, half_count_ = 0.0;  // of this hold
  SamplingRegularity sampling_;
};

// What happens to every sample is inline: a call costs as much as these do.

inline bool LiveChannel::hear(const Record& record) noexcept {
  ++received_;
  if (record.flags & kGap) ++now_.gaps;
  if (record.t_ns <= last_ns_ || !std::isfinite(intake_.si(record.value))) {
    ++out_of_order_;
    return false;
  }
  if (last_ns_ != INT64_MIN && !intake_.held()) sampling_.add(to_s(record.t_ns - last_ns_));
  last_ns_ = record.t_ns;
  return true;
}

inline void LiveChannel::take_plain(PlainRun& run, double omega_rad_s) noexcept {
  intake_.take_plain(run, omega_rad_s);
  if (run.count() == 0) return;
  received_ += run.count();
  sampling_.add_evenly(to_s(run.gap_ns()), run.count());
  last_ns_ = run.last_ns();
  now_.value = intake_.si(run.last());
  now_.t_ns = last_ns_;
  now_.fault = Fault::none;
  now_.overrange = false;
}

inline void LiveChannel::show(const Record& record) noexcept {
  now_.value = intake_.si(record.value);
  now_.t_ns = record.t_ns;
  now_.fault = Fault::none;
  now_.overrange = intake_.overrange();
}

inline double LiveChannel::count(const Reading& reading) noexcept {
  // The rate of the values, not of the readings, decides which harmonics fold.
  if (intake_.held() && refreshed_ns_ != INT64_MIN) sampling_.add(to_s(reading.t_ns - refreshed_ns_));
  refreshed_ns_ = reading.t_ns;
  half_ns_sum_ += reading.half_ns;
  half_count_ += 1.0;
  return intake_.si(reading.value);
}

inline bool LiveChannel::stuck(double period_s) const noexcept {
  if (!intake_.repeats()) return false;
  const double same_for_s = intake_.same_for_s();
  return same_for_s > kStuck_s && same_for_s > kLostPeriods * period_s && intake_.read_same_s() > period_s;
}

}  // namespace dwell
