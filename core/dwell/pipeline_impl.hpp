// The pipeline's parts, and what goes on between them: pipeline.cpp takes the stream in, dwell_cycle.cpp watches the
// drive and tells the state machine of the dwell what has happened, dwell_settling.cpp judges by windows whether the
// transient has decayed, dwell_modes.cpp, dwell_residuals.cpp and dwell_transient.cpp by the natural oscillations;
// dwell_inputs.cpp heeds the interlock and the sync input, dwell_result.cpp makes of all what is reported. Internal to
// core.
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
#include "core/chain/identify.hpp"
#include "core/drive/drive_reference.hpp"
#include "core/drive/drive_tracker.hpp"
#include "core/drive/window_length.hpp"
#include "core/dwell/counted_data.hpp"
#include "core/dwell/dwell_states.hpp"
#include "core/dwell/dwell_times.hpp"
#include "core/dwell/finished_dwell.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/dwell/report.hpp"
#include "core/dwell/settling_windows.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/fit/mains.hpp"
#include "core/intake/live_channels.hpp"
#include "core/model/decay.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/transducer.hpp"
#include "core/rig/usable_observation.hpp"
#include "core/stream/sample_history.hpp"
#include "core/transient/modal_fit.hpp"
#include "core/transient/seen_modes.hpp"
#include "core/transient/settling.hpp"
#include "core/transient/whole_hold.hpp"

namespace dwell {

inline constexpr int kFewestQuarters = 6;            // of data that a dwell must keep
inline constexpr std::size_t kExtraPoles = 2;        // beside the chain's
inline constexpr std::size_t kMains = 8;             // lines of hum, of 50 and 60 Hz
inline constexpr double kRounded = 0.25 + 1.0 / 12;  // steps²: readings of less noise than half a step, and rounding
inline constexpr double kTrust = 0.05;      // relative change of a pole in one step, as far as the data leave it open
inline constexpr int kManyRefinements = 8;  // of poles that are far off
inline constexpr double kUnsure = 1.0;      // periods at the beginning of a hold, which are left out

[[nodiscard]] inline std::size_t history_capacity(int channels) {
  return std::min<std::size_t>(std::size_t{1} << 19, static_cast<std::size_t>(channels) << 15);
}

struct Pipeline::Impl {
  explicit Impl(const Rig& given)
      : rig(given),
        channel_count(static_cast<int>(given.channels.size())),
        H(given.excitation.harmonics),
        live(rig),
        reference(rig),
        data(rig, live, reference),
        tracker(rig, reference),
        windows(rig, live, data, window),
        history(history_capacity(channel_count)),
        modal(channel_count, H, std::min(2 * given.mass_count() + 2, ModalFit::kMaxModes)),
        spare(modal),
        seen_modes(channel_count),
        whole_hold(channel_count, H, std::min(2 * given.mass_count() + 2, ModalFit::kMaxModes), reference.stated()),
        decay(given.boundary, given.masses),
        G(observation_matrix(given)),
        usable_observation(given, G) {
    for (ModalFit* fit : {&modal, &spare}) fit->state_omega(reference.stated());
    const auto channels = static_cast<std::size_t>(channel_count);
    transient.resize(channels);
    ranges.resize(channels);
    left_over.resize(channels);
    noises.resize(channels);
    spectrum.resize(kMains + 400);
    overlap.resize(channels);
    of_quarter.resize(channels);
    for (auto& B : overlap) B.setZero(2, modal.modal_regressors());
    for (auto* poles :
         {&modal_poles, &best_poles, &trial_poles, &extra_poles, &spare_poles, &kept_poles, &kept_extras, &known_poles})
      poles->reserve(4 * given.masses.size() + 4);
    const auto unknowns = static_cast<std::size_t>(rig.mass_count());
    state_x.resize(G.cols());
    Y.resize(unknowns + 1);
    d.resize(unknowns);
    Z.resize(static_cast<std::size_t>(rig.element_count()));
  }

  const Rig rig;
  const int channel_count, H;
  LiveChannels live;
  DriveReference reference;
  CountedData data;
  DriveTracker tracker;
  WindowLength window;
  SettlingWindows windows;
  SampleHistory history;
  ModalFit modal, spare;         // the fit that is believed, and room for another that may turn out better
  std::uint64_t modal_next = 0;  // the first sample of the history that the modal fit has not seen
  std::int64_t modal_refit_at_ns = INT64_MIN, modal_from_ns = 0;
  // Since when the natural oscillations go on undisturbed: since the hold's beginning, or the last knock that was
  // found.
  std::int64_t free_ns = 0;
  std::int64_t knock_ns = INT64_MIN;  // the newest alarm, which the next refit looks at
  bool knocks = false;                // there was an alarm in this hold
  struct Newest {
    double squares = 0.0, count = 0.0;
  };
  std::vector<Newest> of_quarter;          // per channel, residuals of the newest quarter
  std::int64_t refitted_ns = 0;            // when its poles were last refined
  bool modal_fitted = false;               // in this hold
  std::int64_t believe_at_ns = INT64_MIN;  // when the verdict of rounded readings is asked for again
  double kept_w = 0.0;                     // rad/s, of the fit with kept_poles
  int fits_left = 0;                       // of the whole hold, before now must be enough
  double modal_rate = 0.0;                 // rad/s², of the drive as it is fitted
  double modal_skipped = 0.0;              // part of the hold that the modal fit leaves out
  std::int64_t quiet_ns = INT64_MIN;       // until then the transient is taken out of what comes in
  std::vector<Complex> modal_poles, best_poles, trial_poles, extra_poles, spare_poles, kept_poles, kept_extras,
      spectrum, known_poles;
  struct Noise {
    double variance = INFINITY, freedom = 0.0;
    // Of the modal fit's residuals in either half of it, and their numbers.
    double earlier = 0.0, later = 0.0, in_earlier = 0.0, in_later = 0.0;
  };
  std::vector<Noise> noises;   // per channel, of the readings: from what no smooth motion explains
  std::vector<double> ranges;  // per channel, largest distance from the reference over the modal fit
  // Per channel Σ (sin, cos)' (modes): what an error of the modes' amplitudes does to the steady phasor.
  std::vector<Eigen::Matrix<double, 2, Eigen::Dynamic>> overlap;
  SeenModes seen_modes;           // of this hold
  WholeHold whole_hold;           // for the same
  std::vector<double> left_over;  // per channel, what its residuals hold beyond the noise: for these
  DecayRate decay;
  const Eigen::MatrixXd G;
  UsableObservation usable_observation;
  Eigen::VectorXcd state_x;
  std::vector<Complex> Y, d, Z;
  std::vector<double> transient;  // per channel, of its reading: seen of the transient where the data begin to count

  DwellStates states;
  DwellTimes at;
  std::int64_t origin_ns = INT64_MIN, now_ns = INT64_MIN, last_sample_ns = INT64_MIN;
  double time_constant_s = kNaN;
  SettlingDetector::Verdict verdict;
  struct TakenBack {
    std::int64_t verdict_ns = INT64_MIN;  // of the verdict that was premature; INT64_MIN: none in this hold
    int channel = -1;
    double left = 0.0;  // in that channel at that time, over what is allowed
  } taken_back;
  FinishedDwell finished;
  std::uint8_t changes = kNothing;

  [[nodiscard]] bool tracked() const { return reference.tracked(); }
  [[nodiscard]] bool from_motion() const { return reference.from_motion(); }
  [[nodiscard]] double axis_s(std::int64_t ns) const { return ns == INT64_MIN ? kNaN : to_s(ns - origin_ns); }
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

  // What blocks alone show of a channel's noise, whatever else it does; the variance as known by now.
  double learn_noise(int c, double squares, double freedom);

  [[nodiscard]] bool out_of_search() const { return tracker.out_of_search(); }

  // dwell_modes.cpp: the modal fit of the hold so far.
  // ω at modal_from_ns and modal_rate that the drive's channel alone tells of, from the blocks of this hold.
  double drive_omega();
  // Shows the fit the samples that it has not seen.
  void feed_modes();
  // The fit anew, with other poles and ω at modal_from_ns; its misfit.
  double fit_modes(double w, std::span<const Complex> poles);
  void solve_modes();
  // The poles of the chain that the fit's steady motion tells of; none where that cannot be solved.
  std::span<const Complex> chain_poles();
  void keep_alive(std::span<const Complex> poles, std::vector<Complex>& out) const;
  void renew_silent_poles();
  // How often the whole hold may be fitted anew with so many poles.
  [[nodiscard]] int fits_affordable(std::size_t poles) const;
  // trial_poles become best_poles if they explain the data better; the misfit of best_poles.
  double try_poles(double w, double best);
  double refine_poles(double best, int steps);
  void take_best_poles();
  // Everything again: where the hold's data may begin, the poles, what they leave over. false: no poles are known.
  bool refit_modes();
  [[nodiscard]] double slowest_rate() const;
  // Keeps what the fit now shows of the natural oscillations, for the check of the model.
  void remember_modes();

  // dwell_residuals.cpp: what the fit leaves over.
  [[nodiscard]] bool explained() const;
  // Variance of a channel's residuals beyond its noise; not above 0: none.
  [[nodiscard]] double unexplained(int c) const;
  void compare_halves();
  bool find_extra_pole();
  void judge_extra_poles();
  // Whether a steady line beside the drive is fitted.
  [[nodiscard]] bool hums() const;

  // dwell_knocks.cpp: what begins the natural oscillations anew while the rig settles.
  bool knocked_now(std::int64_t from_ns);
  bool fit_since_knock(double w, std::int64_t first_ns);
  void heed_knock(std::int64_t end_ns);
  void refit_after_knock();

  // dwell_transient.cpp: how much of the transient is left, and its being taken out.
  [[nodiscard]] double allowed_left(int c) const;
  [[nodiscard]] double negligible_left(int c) const;
  // The largest part of what is allowed that may be left at t.
  double modal_left(std::int64_t t_ns, int* worst) const;
  // Judges the hold; false: there are no modes to judge by.
  bool settle_by_modes(std::int64_t end_ns);
  bool believed(double left_before);
  [[nodiscard]] bool rounded(int c) const;
  [[nodiscard]] bool determined() const;
  void refit_later(double growth);
  void refit_soon();
  void refit_measuring(std::int64_t end_ns);
  // The modal fit anew, at the frequency and drift of the data that count, where that explains the hold better: whether
  // it does.
  bool follow_drive();
  [[nodiscard]] bool same_drive() const;
  [[nodiscard]] bool transient_matters() const;
  [[nodiscard]] Eigen::Matrix2d transient_covariance(int c, double samples) const;
  void fade_modes(std::int64_t t_ns);
  void take_transient_out(std::int64_t end_ns);
  // The blocks anew from the history, the transient taken out of them where that is known (quiet_ns).
  void rebuild_blocks(std::int64_t begin_ns, std::int64_t end_ns);
  // Where the data begin to count after a verdict at end_ns; INT64_MIN: too few would.
  [[nodiscard]] std::int64_t count_from(std::int64_t end_ns) const;
  bool premature();
  bool mend_verdict(std::int64_t end_ns);
  // A reading into the blocks, without what is known of the transient; what was added.
  double add_cleaned(std::int64_t t_ns, int c, double value);

  [[nodiscard]] int doubtful_quarters() const { return tracker.doubtful_quarters(); }
  // How many blocks end before the newest so many quarters; one that holds some of these does not count.
  [[nodiscard]] int blocks_before(int newest_quarters) const;
  // Why no transient is awaited but something else; empty: nothing else bars.
  [[nodiscard]] std::string barred_reason() const;
  double identified_time_constant(double w);

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
