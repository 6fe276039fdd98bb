// One channel as it delivers: every sample of it passes here, is counted, and is judged by the channel's intake before
// it may count. What was found on the way says whether the channel delivers, is stuck, or is unfit for a verdict.
//
// A dwell's own figures (how late its readings were, how often its values came) begin anew with each hold.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/fit/mains.hpp"
#include "core/intake/channel_intake.hpp"
#include "core/intake/channel_now.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"

namespace dwell {

// Bound to one thread; real-time safe but for the constructor and what makes text.
class LiveChannel {
 public:
  using Reading = ChannelIntake::Reading;

  explicit LiveChannel(const Channel& channel) : intake_(channel) {}

  // A sample that came out of the stream's order: counted, not used.
  void refuse() noexcept { ++received_, ++out_of_order_; }
  // The device has told that the channel does not deliver, or (Fault::none) that it does again.
  void tell(Fault fault) noexcept { now_.fault = fault; }

  // The next sample of the stream, before it is judged. false: not finite, or not after the one before; counted only.
  [[nodiscard]] bool hear(const Record& record) noexcept;
  // Judges the sample just heard; omega_rad_s: of the drive. What has passed now goes to take(const Reading&), oldest
  // first: readings that had to wait for those after them, then this one.
  template <class Take>
  void judge(const Record& record, double omega_rad_s, Take&& take) {
    Reading reading{record.t_ns, record.value, record.t_half_ns};
    const ChannelIntake::Says says = intake_.judge(reading, omega_rad_s);
    show(record);
    if (says != ChannelIntake::Says::take && says != ChannelIntake::Says::give_back) return;
    for (const Reading& waited : intake_.waiting()) take(waited);
    take(reading);
  }
  // A reading that has passed and counts: its value, SI.
  double count(const Reading& reading) noexcept;
  // A reading that has passed, but the channel is stuck.
  void leave_out_stuck() noexcept { ++stuck_; }
  // A reading of this channel has counted, in this hold or before.
  [[nodiscard]] bool has_counted() const noexcept { return refreshed_ns_ != INT64_MIN; }
  // By how much the instant of a reading that counts is less certain than is usual in this hold, s: it was held up.
  [[nodiscard]] double late_s(const Reading& reading) const noexcept;

  // The drive is steady from now on.
  void begin_hold() noexcept;
  // The data count from now on.
  void begin_to_count() noexcept { intake_.begin_to_count(); }
  void next_period() noexcept { intake_.next_period(); }
  void see_residuals(double sigma) noexcept { intake_.see_residuals(sigma); }

  // One and the same reading for longer than a motion of this period allows.
  [[nodiscard]] bool stuck(double period_s) const noexcept;
  // No fault is known of it, and its newest sample is not too old.
  [[nodiscard]] bool delivers(std::int64_t now_ns, double period_s) const noexcept;
  // Its readings are no measure of the motion: stuck, clipped, clustered or mostly left out. tolerance: Rig::tolerance.
  [[nodiscard]] bool unfit(double period_s, double tolerance) const noexcept;

  [[nodiscard]] const ChannelIntake& intake() const noexcept { return intake_; }
  // How regularly its values come: of the refreshes, where the register is held.
  [[nodiscard]] const SamplingRegularity& sampling() const noexcept { return sampling_; }
  // The newest sample's value, SI; NaN: none yet.
  [[nodiscard]] double value() const noexcept { return now_.value; }
  [[nodiscard]] ChannelNow now(double period_s) const noexcept;
  // Standard uncertainty of the instants of this hold's readings by the device's turnaround, s.
  [[nodiscard]] double turnaround_u_s() const noexcept;

  // In words, with figures; empty: nothing is the matter. Allocates.
  [[nodiscard]] std::string condition_reason(double period_s) const;
  // Why it does not deliver, of one that does not.
  [[nodiscard]] std::string silent_reason() const;
  // The fault in short: "timeout"; "silent" where none is known.
  [[nodiscard]] const char* fault_name() const noexcept;
  // Why a phasor of its readings must not be used: amplitude and standard uncertainty of the reading, SI. measuring: a
  // dwell is being measured.
  [[nodiscard]] std::string unfit_reason(double amplitude, double u, bool measuring) const;
  // What a dwell by its readings must tell, each without the channel's name.
  [[nodiscard]] std::vector<std::string> warnings(double tolerance) const;

 private:
  void show(const Record& record) noexcept;

  ChannelIntake intake_;
  ChannelNow now_;
  std::uint64_t received_ = 0, out_of_order_ = 0, stuck_ = 0;  // the latter two were not used
  std::int64_t last_ns_ = INT64_MIN;
  std::int64_t refreshed_ns_ = INT64_MIN;        // of the reading that counted last
  double half_ns_sum_ = 0.0, half_count_ = 0.0;  // of this hold
  SamplingRegularity sampling_;
};

}  // namespace dwell
