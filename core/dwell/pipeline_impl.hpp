// The pipeline's state, shared by the files that hold its parts: pipeline.cpp takes the stream in, dwell_cycle.cpp is
// the state machine of the dwell, dwell_settling.cpp judges by windows whether the transient has decayed,
// dwell_transient.cpp does what the model of the transient (core/transient/transient_model.hpp) says; dwell_data.cpp
// keeps the sums that count and their frequency, dwell_inputs.cpp heeds the interlock and the sync input,
// dwell_result.cpp makes of all what is reported. Internal to core.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/complex.hpp"
#include "core/base/instants.hpp"
#include "core/chain/estimate.hpp"
#include "core/chain/provisional_chain.hpp"
#include "core/drive/drive.hpp"
#include "core/drive/refine.hpp"
#include "core/drive/seen_drive.hpp"
#include "core/drive/step_watch.hpp"
#include "core/drive/sync_reference.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/dwell/report.hpp"
#include "core/fit/blocks.hpp"
#include "core/fit/frequency_prior.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/fit/mains.hpp"
#include "core/intake/channel_intake.hpp"
#include "core/rig/observation.hpp"
#include "core/stream/sample_history.hpp"
#include "core/stream/transactions.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/settling.hpp"
#include "core/transient/transient_model.hpp"

namespace dwell {

inline constexpr double kLostPeriods = 2.0;  // without a sample, and at least kLost_s: a channel no longer delivers
inline constexpr double kLost_s = 1.0;
inline constexpr double kStuck_s = 0.5;  // and at least kLostPeriods with one and the same reading: it is stuck

// An absolute transducer on the table.
[[nodiscard]] inline bool shows_drive(const Channel& channel) {
  return channel.measures != Quantity::force && channel.measures != Quantity::auxiliary && channel.at == 0 &&
         !channel.relative_to;
}

[[nodiscard]] inline std::size_t history_capacity(int channels) {
  return std::min<std::size_t>(std::size_t{1} << 19, static_cast<std::size_t>(channels) << 15);
}

struct Pipeline::Impl {
  explicit Impl(const Rig& given)
      : rig(given),
        stated(stated_frequency(given)),
        channel_count(static_cast<int>(given.channels.size())),
        H(given.excitation.harmonics),
        blocks(channel_count, H),
        window(channel_count, H),
        quarter(channel_count, H),
        counted(channel_count, H),
        gathered(channel_count, H),
        totals(channel_count, H),
        settling(channel_count, given.tolerance),
        drive(given.tolerance),
        watch(given.tolerance),
        sync(given.excitation.search_low_hz, given.excitation.search_high_hz),
        history(history_capacity(channel_count)),
        transactions(given),
        G(observation_matrix(given)),
        provisional_chain(rig, G),
        modes(rig, stated, history, provisional_chain),
        omega(kTwoPi * given.excitation.frequency_hz) {
    for (const Channel& channel : rig.channels) live.emplace_back(channel);
    fits.resize(live.size());
    readings.resize(live.size());
    transient.resize(live.size());
    fitted_channels.resize(live.size());
    for (int c = 0; c < channel_count; ++c) {
      const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
      if (shows_drive(channel) && drive_channel < 0) drive_channel = c;
    }
    for (int c = 0; c < channel_count && drive_channel < 0; ++c) {
      const Quantity measures = rig.channels[static_cast<std::size_t>(c)].measures;
      if (measures != Quantity::force && measures != Quantity::auxiliary) drive_channel = c;
    }
  }

  // One channel as it delivers.
  struct Live {
    explicit Live(const Channel& channel) : intake(channel) {}
    ChannelIntake intake;
    ChannelNow now;
    std::uint64_t received = 0, out_of_order = 0, stuck = 0;  // the latter two were not used
    std::int64_t last_ns = INT64_MIN;
    std::int64_t refreshed_ns = INT64_MIN;       // of the reading that counted last
    double half_ns_sum = 0.0, half_count = 0.0;  // of this dwell
    SamplingRegularity sampling;                 // of the values: of the refreshes, where the register is held
    bool referenced = false;
  };

  const Rig rig;
  const FrequencyPrior stated;  // of the drive's frequency, by the rig file
  const int channel_count, H;
  Blocks blocks;
  mutable Totals window;  // the newest period
  Totals quarter;         // one block alone
  Totals counted;         // all closed blocks of this dwell, kept up to date while measuring
  bool counted_valid = false;
  struct Hold {
    std::int64_t t_ref_ns;
    double phase_rad, omega, u_omega;
    double sigma2;  // of the table's residuals
  } hold{};         // the table's phasor in this dwell, as last counted anew
  int slips = 0, since_in_phase = 0, restarts = 0;
  bool sparse = false;              // the drive's channel has too few samples a period
  mutable Totals gathered, totals;  // what a result rests on: as added up, and at the refined frequency
  SettlingDetector settling;
  DriveMonitor drive;  // while settling
  StepWatch watch;     // while measuring
  SeenDrive seen_drive;
  SyncReference sync;
  SyncReference::Counts pulses_before;  // this hold
  bool permitted = true;                // by the interlock; without one always
  SampleHistory history;
  Transactions transactions;
  const Eigen::MatrixXd G;
  int drive_channel = -1;
  std::vector<Live> live;
  std::vector<HarmonicFit> fits;  // of the newest window
  std::vector<SettlingDetector::Reading> readings;
  ProvisionalChain provisional_chain;
  TransientModel modes;
  std::vector<FittedChannel> fitted_channels;  // of hold_now()
  std::vector<double> transient;  // per channel, of its reading: seen of the transient where the data begin to count

  State state = State::idle;
  double omega;  // rad/s, best known
  std::int64_t origin_ns = INT64_MIN, now_ns = INT64_MIN, last_sample_ns = INT64_MIN;
  int index = 0, low_windows = 0, window_periods = 1;
  std::int64_t armed_ns = 0;  // since when a drive is looked at that has not settled
  std::int64_t start_ns = 0, steady_ns = 0, settled_ns = 0, verdict_ns = 0;
  SettlingDetector::Verdict verdict;
  std::int64_t steady_serial = 0, refine_at_serial = 0;
  std::int64_t solve_at_serial = 0;
  double history_omega = 1.0;  // rad/s, at which the detector's windows were taken
  Dwell finished;
  std::int64_t finished_armed_ns = 0;
  double finished_omega = 1.0;
  bool pending = false;  // `finished` awaits its reason
  std::int64_t pending_until_serial = 0;
  std::uint8_t changes = kNothing;

  // While settling the motion itself shows the frequency, though pulses may give it in the end.
  [[nodiscard]] bool tracked() const { return !stated.exact(); }
  // Whether only the motion tells the frequency, beside what is stated of it.
  [[nodiscard]] bool from_motion() const { return tracked() && !synced(); }
  [[nodiscard]] bool synced() const { return rig.excitation.reference == Reference::sync; }
  [[nodiscard]] double axis_s(std::int64_t ns) const { return ns == INT64_MIN ? kNaN : to_s(ns - origin_ns); }
  [[nodiscard]] double period_s() const { return kTwoPi / omega; }

  void enter(State next) {
    if (next != state) changes |= kStateChanged;
    state = next;
  }

  std::uint8_t push(const Record& record);

  // Brings the blocks up to now.
  void advance();

  void open_block(std::int64_t begin_ns) { blocks.open(begin_ns, begin_ns + to_ns(period_s() / kQuarters), omega); }

  void sample(const Record& record);
  // A reading that counts.
  void take(int c, const ChannelIntake::Reading& reading);
  // dwell_readings.cpp: what a channel's intake found, and what becomes of its phasor by that.
  [[nodiscard]] bool unfit(int c) const;
  // Standard uncertainty of ω, rad/s, by instants of refreshes, in data of that length.
  [[nodiscard]] double refresh_u_omega(double seconds) const;
  void judge_readings(int c, ChannelResult& result) const;
  void warn_of_readings(Dwell& dwell) const;
  // Whether a register has come to be held, or no longer is, while settling: then what came before counts no more.
  [[nodiscard]] bool holding_changed() const;

  // A GPIO edge. The loss of the interlock ends the dwell at once; nothing begins before its return, and nothing from
  // before that counts.
  void edge(const Record& record);

  // Whether a dwell may begin: with pulses as the reference only while they come, within the range that is searched.
  [[nodiscard]] bool has_reference() const;
  // The table moves at another frequency than that of the pulses.
  [[nodiscard]] bool pulses_contradict() const;
  // What is wrong with the reference; empty: nothing.
  [[nodiscard]] std::string reference_reason() const;
  // Why the data in `totals`, taken at the pulses' ω, cannot give coefficients; empty: they can.
  [[nodiscard]] std::string pulses_unfit(double w, double u) const;
  void warn_of_pulses(Dwell& dwell) const;
  // dwell_statement.cpp: while settling, ω of a table that contradicts what is stated of a fixed frequency.
  [[nodiscard]] std::optional<double> contradicting_omega() const;
  [[nodiscard]] std::string statement_reason(double w) const;
  // Why data refined so cannot give coefficients; empty: they can.
  [[nodiscard]] std::string statement_unfit(const Refined& refined, double seconds) const;
  // `sums`, which are over [from, to], at the best ω for them: leaves them in `totals`.
  Refined refine_sums(const Totals& sums, std::int64_t from_ns, std::int64_t to_ns) const;

  void on_block(std::int64_t end_ns);

  // ω from one window of the drive channel, where that is known to a hundredth.
  void acquire(int from, int to, std::int64_t centre_ns);

  // The same reading for longer than a motion at the drive's frequency allows.
  [[nodiscard]] bool stuck(const Live& channel) const {
    return channel.intake.same_for_s() > std::max(kStuck_s, kLostPeriods * period_s());
  }

  // A channel delivers while no fault is known of it and its newest sample is not too old.
  [[nodiscard]] bool delivers(int c) const {
    const Live& channel = live[static_cast<std::size_t>(c)];
    return channel.now.fault == Fault::none && channel.last_ns != INT64_MIN &&
           to_s(now_ns - channel.last_ns) <= std::max(kLost_s, kLostPeriods * period_s());
  }

  // Whether the table's phase has left that of the dwell: a frequency a little off shows in time, wherever the
  // amplitude and the window's own frequency show nothing. Two windows one after the other.
  bool slipped(std::int64_t centre_ns, const HarmonicFit& table);

  void arm(int from);

  // The drive is taken as steady from block `from` on.
  void begin_hold(int from);

  // The drive is another than in this hold. Whether it changed or stopped shows when the change has passed through the
  // window; until then the finished dwell is kept back.
  void change(int from);

  void stop();

  // Ends the run of dwells for another reason than the drive.
  void end(EndedBy ended_by, State next, bool with_open);
  void lose_data();
  void rearm();

  // While nothing is measured the means may be taken anew, so that they never cost digits however long the service
  // runs.
  void refresh_reference();

  // Windows are compared with each other, so all are taken at one ω: when the best known has moved by a part of the
  // tolerance that would show, those of this hold are taken anew.
  void settle(std::int64_t end_ns);

  // Shows the detector the window of blocks [from, to). false: it could not be fitted.
  bool look(int from, int to);

  // Adds what blocks [from, to) tell of a channel's noise, whatever else it does.
  void take_noise(int c, int from, int to);

  [[nodiscard]] bool out_of_search() const {
    const double f = drive.omega() / kTwoPi;
    return !stated.stated() && std::isfinite(f) &&
           (f < rig.excitation.search_low_hz || f > rig.excitation.search_high_hz);
  }

  // dwell_transient.cpp: what the model of the transient is told, and what its verdicts do.
  // What it is told of this moment. Valid until the next call.
  [[nodiscard]] HoldNow hold_now();
  // ω that the drive's channel alone tells of, from the blocks of this hold.
  [[nodiscard]] SeenFrequency drive_omega() const;
  // ω of the data that count.
  [[nodiscard]] SeenFrequency counted_omega() const {
    return {omega, blocks.drift().rate, blocks.drift().about_ns, hold.u_omega};
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

  // Of the newest quarters, those that may hold another drive.
  [[nodiscard]] int doubtful_quarters() const;
  // How many blocks end before the newest so many quarters; one that holds some of these does not count.
  [[nodiscard]] int blocks_before(int newest_quarters) const;
  // Why no transient is awaited but something else; empty: nothing else bars.
  [[nodiscard]] std::string barred_reason() const;

  // Coefficients from the later half of the hold so far, for the decay that they predict: for a chain of which every
  // channel delivers, now and then (the eigenvalues cost n³).
  void provisional();

  // ω and the running sums from all data that count: at the verdict, whenever the data have grown by a sixth, and when
  // the oldest have been forgotten.
  void count_anew(bool follow = true);

  // How the table's frequency drifts, where that shows: into the blocks' drift. Whether it has changed.
  bool follow_drift();
  // The rate, rad/s² beyond the blocks' own, by which the table's frequency drifts over the blocks from `first` on; 0:
  // it does not show, or turns nothing by what matters. w: its frequency at `about`.
  [[nodiscard]] double seen_drift(int first, double w, std::int64_t about_ns) const;
  // ω at t of a drive of which it is w where the blocks' drift is about.
  [[nodiscard]] double omega_at(std::int64_t t_ns, double w) const {
    return w + blocks.drift().rate * to_s(t_ns - blocks.drift().about_ns);
  }
  // By what the drift has turned the drive at t beyond the phase that sums are of, rad.
  [[nodiscard]] double bend(std::int64_t t_ns) const {
    const double since_s = to_s(t_ns - blocks.drift().about_ns);
    return 0.5 * blocks.drift().rate * since_s * since_s;
  }
  void refer_drift(std::int64_t about_ns);

  // The first blocks of a hold may have been taken before its frequency was known; turning them loses (δu)²/6. Where
  // that is no small part of the uncertainty they go, if they are no large part of the data.
  bool drop_misjudged();

  // The sums over blocks [from, to) and the open one, refined: leaves them in `totals`.
  Refined gather(int from, int to, bool with_open) const;

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
