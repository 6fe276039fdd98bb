// The pipeline's parts and the events between them. Internal to core.
//
// pipeline.cpp takes the stream in. dwell_cycle.cpp watches the drive and reports events to the dwell's state machine.
// dwell_settling.cpp judges by windows whether the transient has decayed. dwell_transient.cpp carries out the verdicts
// of the transient's model (core/transient/transient_model.hpp). dwell_inputs.cpp handles the interlock and the sync
// input. dwell_reasons.cpp says why the dwell is where it is, and dwell_result.cpp makes the reports.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/chain/estimate.hpp"
#include "core/chain/provisional_chain.hpp"
#include "core/drive/drive_reference.hpp"
#include "core/drive/drive_tracker.hpp"
#include "core/drive/frequency_search.hpp"
#include "core/dwell/counted_data.hpp"
#include "core/dwell/dwell_draft.hpp"
#include "core/dwell/dwell_states.hpp"
#include "core/dwell/dwell_times.hpp"
#include "core/dwell/errors_in_motion.hpp"
#include "core/dwell/finished_dwell.hpp"
#include "core/dwell/history_capacity.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/dwell/report.hpp"
#include "core/dwell/settling_windows.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/fit/mains.hpp"
#include "core/intake/live_channels.hpp"
#include "core/intake/plain_run.hpp"
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
        search(rig),
        windows(rig, live, data),
        history(history_capacity(live.count()), slices),
        G(observation_matrix(given)),
        provisional_chain(rig, G, slices),
        modes(rig, reference.stated(), history, provisional_chain),
        errors_in_motion(live.count()) {
    runs.resize(static_cast<std::size_t>(live.count()));
    fitted_channels.resize(static_cast<std::size_t>(live.count()));
  }

  const Rig rig;
  LiveChannels live;
  DriveReference reference;
  CountedData data;
  DriveTracker tracker;
  FrequencySearch search;
  SettlingWindows windows;
  SampleHistory history;
  const Eigen::MatrixXd G;
  ProvisionalChain provisional_chain;
  TransientModel modes;
  ErrorsInMotion errors_in_motion;
  std::vector<PlainRun> runs;                  // storage for take_in_block(), by channel
  std::vector<FittedChannel> fitted_channels;  // storage for hold_now()

  DwellStates states;
  DwellTimes at;
  std::int64_t now_ns = INT64_MIN;
  SettlingDetector::Verdict verdict;
  FinishedDwell finished;
  std::uint8_t changes = kNothing;

  [[nodiscard]] int harmonics() const { return rig.excitation.harmonics; }
  [[nodiscard]] bool inexact() const { return reference.inexact(); }
  [[nodiscard]] bool from_motion() const { return reference.from_motion(); }
  [[nodiscard]] double axis_s(std::int64_t ns) const { return ns == INT64_MIN ? kNaN : to_s(ns - at.origin_ns); }
  [[nodiscard]] const Blocks& blocks() const { return data.blocks(); }
  [[nodiscard]] double omega() const { return data.omega(); }
  [[nodiscard]] double period_s() const { return data.period_s(); }

  std::uint8_t push(const Record& record);
  void take_record(const Record& record);
  std::size_t take_in_block(std::span<const Record> records);
  // How many records the open block takes as they come, up to `most`: samples and ticks. Gathers their readings in
  // `runs`.
  std::size_t gather_in_block(std::span<const Record> records, std::size_t most);

  // Closes blocks and opens new ones up to now_ns.
  void advance();

  void sample(const Record& record);
  // Takes a reading of channel c, live[c], that counts.
  void take(int c, LiveChannel& channel, const LiveChannel::Reading& reading);
  // A GPIO edge. If the interlock opens, the dwell ends at once. Nothing begins until it closes; earlier data do not
  // count.
  void edge(const Record& record);

  // While settling: the table's ω if it contradicts the stated one of a fixed frequency.
  [[nodiscard]] std::optional<double> contradicting_omega() const;

  void on_block(std::int64_t end_ns);

  // Finds the drive's ω, rad/s, near enough for the first fit of the newest window. Searches the whole search range;
  // call it only while ω is unknown. If the blocks were built with another ω, it rebuilds them, and a hold begins.
  double search_drive(std::int64_t end_ns);
  // Largest amplitude of the table at a multiple of ω in the search range, m (rad).
  [[nodiscard]] double moves_elsewhere(const HarmonicFit& fit) const;

  [[nodiscard]] int drive_channel() const { return live.drive(); }
  [[nodiscard]] bool delivers(int c) const { return live[c].delivers(now_ns, period_s()); }
  [[nodiscard]] double refresh_u_omega(double seconds) const { return live.refresh_u_omega(seconds, omega()); }
  // Withholds a channel's phasor or widens its uncertainty by what the intake found in its readings.
  void judge_readings(int c, ChannelResult& result) const;

  [[nodiscard]] DriveTracker::During during() const;
  // Evaluates the newest window of the drive, which begins at block `from`. A dwell may be armed, or all may end.
  // false: there is no drive to judge further.
  bool look_at_drive(const DriveTracker::Window& table, int from);

  void arm(int from);

  // The drive counts as steady from block `from` on.
  void begin_hold(int from);

  // The drive is no longer that of this hold. It is known whether it changed or stopped only after the change has
  // passed through the window. Until then the finished dwell is kept back.
  void change(int from);

  void stop();

  // Ends the present dwell for a reason other than the drive.
  void end(EndedBy ended_by, bool with_open);
  void lose_data();
  void rearm();

  // While no dwell is on: takes the channels' references anew, so that a drifting mean never costs digits, however long
  // the service runs.
  void refresh_reference();

  void settle(std::int64_t end_ns);

  // Shows the detector the window of blocks [from, to). false: it could not be fitted.
  bool look(int from, int to);

  [[nodiscard]] bool out_of_search() const { return tracker.out_of_search(); }

  // dwell_transient.cpp: the input of the transient's model at this moment, valid until the next call; and what its
  // verdicts do.
  [[nodiscard]] HoldNow hold_now();
  // ω from the drive's channel alone, over the blocks of this hold.
  [[nodiscard]] SeenFrequency drive_omega() const;
  // ω of the data that count.
  [[nodiscard]] SeenFrequency counted_omega() const {
    return {omega(), data.drift().rate, data.drift().about_ns, tracker.u_omega()};
  }
  // Judges the hold by its modes; false: there are none.
  bool settle_by_modes(std::int64_t end_ns);
  void refit_measuring(std::int64_t end_ns);
  bool mend_verdict(std::int64_t end_ns);
  [[nodiscard]] bool transient_matters() const;
  void take_transient_out(std::int64_t end_ns);
  // Builds the blocks anew from the history, without the known transient.
  void rebuild_blocks(std::int64_t begin_ns, std::int64_t end_ns);
  // Adds a reading to the blocks, without the known transient. Returns the value added.
  double add_cleaned(std::int64_t t_ns, int c, double value);

  [[nodiscard]] int doubtful_quarters() const { return tracker.doubtful_quarters(); }
  // Number of blocks that end before the newest so many quarters.
  [[nodiscard]] int blocks_before(int newest_quarters) const;
  // Why the dwell waits for something other than the transient; empty: it does not.
  [[nodiscard]] std::string barred_reason() const;
  // Why the drive is not seen, where its channel was lost; empty: it was not.
  [[nodiscard]] std::string unseen_reason() const;
  [[nodiscard]] std::string at_rest_reason() const;

  // Identifies the chain from the later half of the hold, to predict the decay. Now and then (the eigenvalues cost n³),
  // and only if the usable channels show every mass.
  void provisional();

  // Takes ω and running sums anew from all data that count, and compares the drive with these from now on.
  void resum();

  // Looks for errors that grow with the motion in the blocks before `to`: at once, or a part of the look.
  void look_for_moving_errors(int to, bool at_once);
  [[nodiscard]] int every(int c) const { return ErrorsInMotion::every(live[c].sampling().interval_s(), period_s()); }
  // What the look asks of channel c, about about_ns; `fit` has its phases about t_ref_ns.
  [[nodiscard]] ErrorsInMotion::About about_moving(int c, HarmonicFit fit, std::int64_t t_ref_ns,
                                                   std::int64_t about_ns) const;

  void conclude(int to, bool with_open);

  void emit(EndedBy ended_by);

  // Evaluates blocks up to `to`. up_to_now: withholds channels that do not deliver now; without it a dwell that has
  // ended keeps them.
  [[nodiscard]] Dwell evaluate(int to, bool with_open, bool up_to_now) const;
  [[nodiscard]] DwellDraft draft(int to, bool with_open, bool up_to_now) const;
  // The blocks [from, to) of an evaluation, and the open one with `with_open`.
  struct Evaluated {
    int from, to;
    bool with_open;
    bool settled;          // they give coefficients; otherwise they are the newest window
    double seconds;        // that they cover
    std::int64_t last_ns;  // their last sample
  };
  [[nodiscard]] Evaluated evaluated(int to, bool with_open) const;
  [[nodiscard]] Dwell heading() const;
  // From data.totals(), which hold the sums of these blocks.
  [[nodiscard]] std::vector<ChannelResult> channel_results(const Evaluated& of, bool up_to_now) const;
  [[nodiscard]] double u_omega_of(double u, const ChannelResult& table, double seconds) const;
  void widen_by_folding(std::vector<ChannelResult>& results, double w, double seconds, Dwell& dwell) const;
  [[nodiscard]] std::vector<std::string> uneven_reasons(int c, const ChannelResult& result,
                                                        const ChannelPhasor& phasor) const;
  void warn_of_readings(const std::vector<ChannelResult>& results, Dwell& dwell) const;
  void tell_not_settled(Dwell& dwell) const;
  void tell_settled(Dwell& dwell) const;
  [[nodiscard]] std::string settling_reason() const;
  // The first channel with too many readings left out as foreign; -1: none.
  [[nodiscard]] int foreign_channel() const;
  [[nodiscard]] std::string left_out_of_dwell() const;
  [[nodiscard]] std::string taken_back_reason() const;
  // The oscillations beside drive and chain, for the settling reason; empty: none.
  [[nodiscard]] std::string foreign_oscillations() const;
  // Standard uncertainty of either component of a reading's phasor by rounding.
  [[nodiscard]] double quantization_u(int c, const HarmonicFit& fit, const Totals& from) const;
  // Warns where hum cannot be told from a harmonic.
  void warn_of_hum(double seconds, Dwell& dwell) const;
  // fits: of data.totals().
  [[nodiscard]] ChannelResult result_of(int c, bool up_to_now, HarmonicFits& fits) const;
  // dwell_steadiness.cpp: changes within blocks [from, to), whose sums data.totals() holds.
  void look_within(int from, int to, double seconds, HarmonicFits& fits, std::vector<ChannelResult>& results) const;
  [[nodiscard]] double turned_by_refresh(int c, const HarmonicFit& fit) const;
  [[nodiscard]] double variance_since_fitted(const HarmonicFit& table) const;
  void look_at_settling(std::vector<ChannelResult>& results) const;
  void warn_of_change(const std::vector<ChannelResult>& results, double seconds, Dwell& dwell) const;
  [[nodiscard]] double frequency_widens(const ChannelResult& table) const;
};

}  // namespace dwell
