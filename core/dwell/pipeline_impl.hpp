// The pipeline's parts, and what goes on between them: pipeline.cpp takes the stream in, dwell_cycle.cpp watches the
// drive and tells the state machine of the dwell what has happened, dwell_settling.cpp judges by windows whether the
// transient has decayed, dwell_transient.cpp does what the model of the transient (core/transient/transient_model.hpp)
// says; dwell_inputs.cpp heeds the interlock and the sync input, dwell_result.cpp makes of all what is reported.
// Internal to core.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/chain/estimate.hpp"
#include "core/chain/provisional_chain.hpp"
#include "core/drive/drive_reference.hpp"
#include "core/drive/drive_tracker.hpp"
#include "core/drive/window_length.hpp"
#include "core/dwell/counted_data.hpp"
#include "core/dwell/dwell_states.hpp"
#include "core/dwell/dwell_times.hpp"
#include "core/dwell/finished_dwell.hpp"
#include "core/dwell/history_capacity.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/dwell/report.hpp"
#include "core/dwell/settling_windows.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/fit/mains.hpp"
#include "core/intake/live_channels.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/transducer.hpp"
#include "core/stream/sample_history.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/settling.hpp"
#include "core/transient/transient_model.hpp"

namespace dwell {

struct Pipeline::Impl {
  Impl(const Rig& given, Slices* slices)
      : rig(given),
        live(rig),
        reference(rig),
        data(rig, live, reference),
        tracker(rig, reference),
        windows(rig, live, data, window),
        history(history_capacity(live.count()), slices),
        G(observation_matrix(given)),
        provisional_chain(rig, G, slices),
        modes(rig, reference.stated(), history, provisional_chain) {
    transient.resize(static_cast<std::size_t>(live.count()));
    fitted_channels.resize(static_cast<std::size_t>(live.count()));
  }

  const Rig rig;
  LiveChannels live;
  DriveReference reference;
  CountedData data;
  DriveTracker tracker;
  WindowLength window;
  SettlingWindows windows;
  SampleHistory history;
  const Eigen::MatrixXd G;
  ProvisionalChain provisional_chain;
  TransientModel modes;
  std::vector<FittedChannel> fitted_channels;  // of hold_now()
  std::vector<double> transient;  // per channel, of its reading: seen of the transient where the data begin to count

  DwellStates states;
  DwellTimes at;
  std::int64_t now_ns = INT64_MIN;
  SettlingDetector::Verdict verdict;
  FinishedDwell finished;
  std::uint8_t changes = kNothing;

  [[nodiscard]] int harmonics() const { return rig.excitation.harmonics; }
  [[nodiscard]] bool tracked() const { return reference.tracked(); }
  [[nodiscard]] bool from_motion() const { return reference.from_motion(); }
  [[nodiscard]] double axis_s(std::int64_t ns) const { return ns == INT64_MIN ? kNaN : to_s(ns - at.origin_ns); }
  [[nodiscard]] const Blocks& blocks() const { return data.blocks(); }
  [[nodiscard]] double omega() const { return data.omega(); }
  [[nodiscard]] double period_s() const { return data.period_s(); }

  std::uint8_t push(const Record& record);
  void take_record(const Record& record);

  // Brings the blocks up to now.
  void advance();

  void sample(const Record& record);
  // A reading that counts.
  void take(int c, const LiveChannel::Reading& reading);
  // A GPIO edge. The loss of the interlock ends the dwell at once; nothing begins before its return, and nothing from
  // before that counts.
  void edge(const Record& record);

  // While settling, ω of a table that contradicts what is stated of a fixed frequency.
  [[nodiscard]] std::optional<double> contradicting_omega() const;

  void on_block(std::int64_t end_ns);

  // The channel by which the drive is known.
  [[nodiscard]] int drive_channel() const { return live.drive(); }
  [[nodiscard]] bool delivers(int c) const { return live[c].delivers(now_ns, period_s()); }
  [[nodiscard]] double refresh_u_omega(double seconds) const { return live.refresh_u_omega(seconds, omega()); }
  // What becomes of a channel's phasor by what its intake has found in its readings.
  void judge_readings(int c, ChannelResult& result) const;

  [[nodiscard]] DriveTracker::During during() const;
  // What the newest window says of the drive, which begins at block `from`: a dwell may be armed by it, or all be over.
  // false: there is nothing to judge in it.
  bool look_at_drive(const DriveTracker::Window& table, int from);

  void arm(int from);

  // The drive is taken as steady from block `from` on.
  void begin_hold(int from);

  // The drive is another than in this hold. Whether it changed or stopped shows when the change has passed through the
  // window; until then the finished dwell is kept back.
  void change(int from);

  void stop();

  // Ends the run of dwells for another reason than the drive.
  void end(EndedBy ended_by, bool with_open);
  void lose_data();
  void rearm();

  // While nothing is measured the means may be taken anew, so that they never cost digits however long the service
  // runs.
  void refresh_reference();

  void settle(std::int64_t end_ns);

  // Shows the detector the window of blocks [from, to). false: it could not be fitted.
  bool look(int from, int to);

  [[nodiscard]] bool out_of_search() const { return tracker.out_of_search(); }

  // dwell_transient.cpp: what the model of the transient is told, and what its verdicts do.
  // What it is told of this moment. Valid until the next call.
  [[nodiscard]] HoldNow hold_now();
  // ω that the drive's channel alone tells of, from the blocks of this hold.
  [[nodiscard]] SeenFrequency drive_omega() const;
  // ω of the data that count.
  [[nodiscard]] SeenFrequency counted_omega() const {
    return {omega(), data.drift().rate, data.drift().about_ns, tracker.u_omega()};
  }
  // Judges the hold; false: there are no modes to judge by.
  bool settle_by_modes(std::int64_t end_ns);
  void refit_measuring(std::int64_t end_ns);
  bool mend_verdict(std::int64_t end_ns);
  [[nodiscard]] bool transient_matters() const;
  void take_transient_out(std::int64_t end_ns);
  // The blocks anew from the history, the transient taken out of them where that is known.
  void rebuild_blocks(std::int64_t begin_ns, std::int64_t end_ns);
  // A reading into the blocks, without what is known of the transient; what was added.
  double add_cleaned(std::int64_t t_ns, int c, double value);

  [[nodiscard]] int doubtful_quarters() const { return tracker.doubtful_quarters(); }
  // How many blocks end before the newest so many quarters; one that holds some of these does not count.
  [[nodiscard]] int blocks_before(int newest_quarters) const;
  // Why no transient is awaited but something else; empty: nothing else bars.
  [[nodiscard]] std::string barred_reason() const;

  // Coefficients from the later half of the hold so far, for the decay that they predict: for a chain of which every
  // channel delivers, now and then (the eigenvalues cost n³).
  void provisional();

  // ω and the running sums from all data that count, and what the drive is held against from now on.
  void count_anew();

  void conclude(int to, bool with_open);

  void emit(EndedBy ended_by);

  // Blocks up to `to`. up_to_now: a channel that does not deliver now is withheld; a dwell that has ended keeps what it
  // had.
  [[nodiscard]] Dwell evaluate(int to, bool with_open, bool up_to_now) const;
  [[nodiscard]] std::string settling_reason() const;
  [[nodiscard]] std::string left_out_of_dwell() const;
  [[nodiscard]] std::string taken_back_reason() const;
  // Of the reason: what swings beside drive and chain; empty: nothing.
  [[nodiscard]] std::string foreign_oscillations() const;
  // Standard uncertainty of either component of a phasor of the reading by rounding.
  [[nodiscard]] double quantization_u(int c, const HarmonicFit& fit, const Totals& from) const;
  // Says where hum cannot be told from a harmonic.
  void warn_of_hum(double seconds, Dwell& dwell) const;
  [[nodiscard]] ChannelResult result_of(int c, bool up_to_now) const;
  // dwell_steadiness.cpp: what blocks [from, to), which `totals` hold, say of change within them.
  void look_within(int c, int from, int to, ChannelResult& result) const;
  void look_at_settling(std::vector<ChannelResult>& results) const;
  void warn_of_change(const std::vector<ChannelResult>& results, double seconds, Dwell& dwell) const;
  [[nodiscard]] double frequency_widens(const ChannelResult& table) const;
};

}  // namespace dwell
