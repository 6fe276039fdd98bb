#include "core/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/blocks.hpp"
#include "core/decay.hpp"
#include "core/drive.hpp"
#include "core/estimate.hpp"
#include "core/harmonic_fit.hpp"
#include "core/identify.hpp"
#include "core/observation.hpp"
#include "core/refine.hpp"
#include "core/report.hpp"
#include "core/scatter.hpp"
#include "core/settling.hpp"
#include "core/transducer.hpp"

namespace dwell {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr int kQuarters = 4;               // windows of one period
constexpr std::int64_t kEmptyBlocks = 64;  // without a record: the time between is skipped, not stepped through
constexpr double kLostPeriods = 2.0;       // without a sample, and at least kLost_s: a channel no longer delivers
constexpr double kLost_s = 1.0;
constexpr int kLargestSolved = 64;  // masses; beyond, the eigenvalues cost more than they tell
constexpr double kStuck_s = 0.5;    // and at least kLostPeriods with one and the same reading: it is stuck
constexpr double kInPhase_rad = 0.02;
constexpr double kSlip_rad = 0.1;       // of the table's phase against the dwell's, beyond noise: another frequency
constexpr double kShortest = 5.0;       // periods: what ended sooner without settling is not told
constexpr double kSureOfScatter = 2.0;  // standard deviations of the scatter beyond which residuals are not white
constexpr double kUnsteady = 9.0;       // ratio of variances that an operator is told of
constexpr std::int64_t kLatest_ns = std::int64_t{1} << 61;  // 73 years
constexpr std::int64_t kLongestPending = 256;  // quarters that a finished dwell is kept back to learn why it ended
constexpr int kFewestQuarters = 6;             // of data that a dwell must keep
constexpr int kManyRestarts = 6;               // of a hold, one after the other, that want to be explained
constexpr int kTurns = 3;                      // times that data are summed anew at a better ω
constexpr std::int64_t kEnoughQuarters = 40;   // of which an eighth may go
constexpr double kMisjudged = 3e-4;            // relative error of ω in a block whose turning costs 1e-8
constexpr double kGrowth = 1.17;               // of the data, before ω is refined again

// An absolute transducer on the table.
bool shows_drive(const Channel& channel) {
  return channel.measures != Quantity::force && channel.measures != Quantity::auxiliary && channel.at == 0 &&
         !channel.relative_to;
}

std::int64_t to_ns(double s) { return static_cast<std::int64_t>(std::llround(s * 1e9)); }
double to_s(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace

struct Pipeline::Impl {
  explicit Impl(const Rig& given)
      : rig(given),
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
        decay(given.boundary, given.masses),
        G(observation_matrix(given)),
        omega(kTwoPi * given.excitation.frequency_hz) {
    live.resize(static_cast<std::size_t>(channel_count));
    fits.resize(live.size());
    readings.resize(live.size());
    transient.resize(live.size());
    for (int c = 0; c < channel_count; ++c) {
      const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
      Live& delivering = live[static_cast<std::size_t>(c)];
      delivering.gain = channel.si_per_unit * channel.scale;
      delivering.offset = channel.si_per_unit * channel.offset;
      delivering.low = channel.range_low.value_or(-INFINITY) * channel.si_per_unit;
      delivering.high = channel.range_high.value_or(INFINITY) * channel.si_per_unit;
      if (shows_drive(channel) && drive_channel < 0) drive_channel = c;
    }
    for (int c = 0; c < channel_count && drive_channel < 0; ++c) {
      const Quantity measures = rig.channels[static_cast<std::size_t>(c)].measures;
      if (measures != Quantity::force && measures != Quantity::auxiliary) drive_channel = c;
    }
    const auto unknowns = static_cast<std::size_t>(rig.mass_count());
    provisional_gain = solve_observation(G, Eigen::VectorXd::Ones(G.rows()));
    observed.resize(G.rows());
    state_x.resize(G.cols());
    Y.resize(unknowns + 1);
    d.resize(unknowns);
    Z.resize(static_cast<std::size_t>(rig.element_count()));
  }

  // One channel as it delivers.
  struct Live {
    double gain = 1.0, offset = 0.0, low = -INFINITY, high = INFINITY;  // SI
    ChannelNow now;
    std::int64_t last_ns = INT64_MIN, changed_ns = INT64_MIN;
    double half_ns_sum = 0.0, half_count = 0.0;  // of this dwell
    double step = INFINITY;  // smallest difference of two readings one after the other, in this hold: SI
    std::uint64_t overrange = 0;
    bool referenced = false;
  };

  const Rig rig;
  const int channel_count, H;
  Blocks blocks;
  mutable Totals window;  // the newest period
  Totals quarter;         // one block alone
  Totals counted;         // all closed blocks of this dwell, kept up to date while measuring
  bool counted_valid = false;
  struct Hold {
    std::int64_t t_ref_ns;
    double phase_rad, omega, u_omega;
  } hold{};  // the table's phasor in this dwell, as last counted anew
  int slips = 0, since_in_phase = 0, restarts = 0;
  bool sparse = false;              // the drive's channel has too few samples a period
  mutable Totals gathered, totals;  // what a result rests on: as added up, and at the refined frequency
  SettlingDetector settling;
  DriveMonitor drive;
  DecayRate decay;
  const Eigen::MatrixXd G;
  int drive_channel = -1;
  std::vector<Live> live;
  std::vector<HarmonicFit> fits;  // of the newest window
  std::vector<SettlingDetector::Reading> readings;
  Gain provisional_gain;
  Eigen::VectorXcd observed, state_x;
  std::vector<Complex> Y, d, Z;
  std::vector<double> transient;  // per channel, of its reading: seen of the transient where the data begin to count

  State state = State::idle;
  double omega;  // rad/s, best known
  std::int64_t origin_ns = INT64_MIN, now_ns = INT64_MIN, last_sample_ns = INT64_MIN;
  int index = 0, low_windows = 0, window_periods = 1;
  std::int64_t start_ns = 0, steady_ns = 0, settled_ns = 0, verdict_ns = 0;
  double time_constant_s = kNaN;
  SettlingDetector::Verdict verdict;
  std::int64_t steady_serial = 0, refine_at_serial = 0;
  std::int64_t solve_at_serial = 0;
  double history_omega = 1.0;  // rad/s, at which the detector's windows were taken
  Dwell finished;
  double finished_omega = 1.0;
  bool pending = false;  // `finished` awaits its reason
  std::int64_t pending_until_serial = 0;
  std::uint8_t changes = kNothing;

  [[nodiscard]] bool tracked() const { return rig.excitation.reference != Reference::fixed; }
  [[nodiscard]] double axis_s(std::int64_t ns) const { return ns == INT64_MIN ? kNaN : to_s(ns - origin_ns); }
  [[nodiscard]] double period_s() const { return kTwoPi / omega; }

  void enter(State next) {
    if (next != state) changes |= kStateChanged;
    state = next;
  }

  std::uint8_t push(const Record& record) {
    changes = kNothing;
    if (origin_ns == INT64_MIN) {
      origin_ns = now_ns = record.t_ns;
    }
    if (record.t_ns < now_ns ||
        record.t_ns > kLatest_ns) {  // not in order, or no instant: counted where there is something to count
      if (record.kind == Kind::sample && record.channel < live.size()) ++live[record.channel].now.rejected;
      return changes;
    }
    now_ns = record.t_ns;
    advance();
    switch (record.kind) {
      case Kind::sample:
        sample(record);
        break;
      case Kind::channel_state:
        if (record.channel < live.size()) live[record.channel].now.fault = static_cast<Fault>(record.flags);
        break;
      case Kind::action:
        if (record.flags == static_cast<std::uint8_t>(Action::rearm)) rearm();
        break;
      case Kind::edge:
      case Kind::tick:
        break;
    }
    return changes;
  }

  // Brings the blocks up to now.
  void advance() {
    if (!blocks.is_open()) {
      open_block(now_ns);
      return;
    }
    const auto quarter_ns = to_ns(period_s() / kQuarters);
    if (now_ns - blocks.open_end_ns() > kEmptyBlocks * quarter_ns) {
      blocks.close();
      lose_data();
      blocks.clear();
      open_block(now_ns);
      return;
    }
    while (now_ns >= blocks.open_end_ns()) {
      const std::int64_t end = blocks.open_end_ns();
      blocks.close();
      on_block(end);
      open_block(end);
    }
  }

  void open_block(std::int64_t begin_ns) { blocks.open(begin_ns, begin_ns + to_ns(period_s() / kQuarters), omega); }

  void sample(const Record& record) {
    if (record.channel >= live.size()) return;
    Live& channel = live[record.channel];
    if (record.flags & kGap) ++channel.now.gaps;
    const double value = channel.gain * record.value + channel.offset;
    if (record.t_ns <= channel.last_ns || !std::isfinite(value)) {
      ++channel.now.rejected;
      return;
    }
    channel.last_ns = record.t_ns;
    if (const double step = std::abs(value - channel.now.value); step != 0) {
      channel.changed_ns = record.t_ns;
      if (step < channel.step) channel.step = step;
    }
    channel.now.value = value;
    channel.now.t_ns = record.t_ns;
    channel.now.fault = Fault::none;
    channel.now.overrange = value < channel.low || value > channel.high;
    if (channel.now.overrange) {
      ++channel.now.rejected;
      ++channel.overrange;
      return;
    }
    if (stuck(channel) && (state == State::settling || state == State::measuring)) {
      ++channel.now.rejected;
      return;
    }
    ++channel.now.used;
    channel.half_ns_sum += record.t_half_ns;
    channel.half_count += 1.0;
    last_sample_ns = record.t_ns;
    if (!channel.referenced) {
      blocks.set_reference(record.channel, value);
      channel.referenced = true;
    }
    blocks.add(record.channel, record.t_ns, value);
  }

  void on_block(std::int64_t end_ns) {
    if (blocks.forget_before(end_ns - to_ns(rig.memory_s))) counted_valid = false;
    if (counted_valid) blocks.add_block(blocks.count() - 1, counted);
    const int quarters = kQuarters * window_periods;
    if (blocks.count() < quarters) return;
    const int from = blocks.count() - quarters, to = blocks.count();
    const std::int64_t begin_ns = blocks.block(from).begin_ns;
    const std::int64_t centre_ns = begin_ns + (end_ns - begin_ns) / 2;

    // Before a period has shown the drive's frequency by its phase, the window itself tells it well enough that the
    // first windows do not differ from the later ones for their frequency alone.
    if (tracked() && !std::isfinite(drive.omega())) acquire(from, to, centre_ns);
    blocks.sum_channel(drive_channel, from, to, omega, centre_ns, window);
    const HarmonicFit table = fit_harmonics(window, drive_channel, H, blocks.reference(drive_channel));
    if (!delivers(drive_channel)) return lose_data();
    if (!table.usable) {
      // So few samples a period that one alone cannot be solved: look at two.
      if (window_periods == 1)
        window_periods = 2;
      else
        sparse = table.samples > 0;
      return;
    }
    sparse = false;
    const Complex Y0 = as_observed(rig, drive_channel, table.X[0], omega, 1);
    const double per_reading = std::abs(Y0) / std::max(std::abs(table.X[0]), 1e-300);
    // From few degrees of freedom the noise is itself uncertain.
    const double few = 1 + 4 / std::max(1.0, table.samples - (2 * H + 1));
    const double u0 = few * std::sqrt(0.5 * table.covariance.trace()) * per_reading;

    if (std::abs(Y0) < rig.excitation.minimum || std::abs(Y0) < 3 * u0) {
      if (++low_windows >= 2) {
        stop();
      } else if (pending && blocks.serials() >= pending_until_serial) {
        emit(EndedBy::drive_changed);
      }
      if (state == State::idle || state == State::fault) refresh_reference();
      return;
    }
    low_windows = 0;
    // A drive that has been steady again for two periods has changed; one that is still on its way may stop.
    if (pending && (blocks.serials() - steady_serial >= (2 * window_periods + 1) * kQuarters ||
                    blocks.serials() >= pending_until_serial))
      emit(EndedBy::drive_changed);
    // Noise alone must not begin a dwell: five standard deviations are passed once in 300 000 windows.
    if (state == State::idle || state == State::fault) {
      if (std::abs(Y0) < 5 * u0) return refresh_reference();
      arm(from);
    }
    if (drive.update(to_s(centre_ns - steady_ns), Y0, u0, omega) || slipped(centre_ns, table)) return change(from);
    if (state == State::settling) {
      if (tracked() && std::isfinite(drive.omega())) omega = within_search(rig, drive.omega());
      settle(end_ns);
    } else if (state == State::measuring && (!counted_valid || blocks.serials() >= refine_at_serial)) {
      count_anew();
    }
  }

  // ω from one window of the drive channel, where that is known to a hundredth.
  void acquire(int from, int to, std::int64_t centre_ns) {
    double w = kTwoPi * rig.excitation.frequency_hz, information = 0.0;
    for (int step = 0; step < 10; ++step) {
      blocks.sum_channel(drive_channel, from, to, w, centre_ns, window);
      const HarmonicFit fit = fit_harmonics(window, drive_channel, H, blocks.reference(drive_channel));
      if (!(fit.information > 0)) return;
      information = fit.information;
      w = within_search(rig, w + fit.score / fit.information);
    }
    if (1 / std::sqrt(information) < 1e-2 * w) omega = w;
  }

  // The same reading for longer than a motion at the drive's frequency allows.
  [[nodiscard]] bool stuck(const Live& channel) const {
    return channel.changed_ns != INT64_MIN &&
           to_s(channel.last_ns - channel.changed_ns) > std::max(kStuck_s, kLostPeriods * period_s());
  }

  // A channel delivers while no fault is known of it and its newest sample is not too old.
  [[nodiscard]] bool delivers(int c) const {
    const Live& channel = live[static_cast<std::size_t>(c)];
    return channel.now.fault == Fault::none && channel.last_ns != INT64_MIN &&
           to_s(now_ns - channel.last_ns) <= std::max(kLost_s, kLostPeriods * period_s());
  }

  // Whether the table's phase has left that of the dwell: a frequency a little off shows in time, wherever the
  // amplitude and the window's own frequency show nothing. Two windows one after the other.
  bool slipped(std::int64_t centre_ns, const HarmonicFit& table) {
    if (state != State::measuring || !counted_valid) return false;
    const double since_s = to_s(centre_ns - hold.t_ref_ns);
    const double off = std::remainder(std::arg(table.X[0]) - hold.phase_rad - hold.omega * since_s, kTwoPi);
    const double u =
        std::hypot(std::sqrt(0.5 * table.covariance.trace()) / std::abs(table.X[0]), hold.u_omega * since_s);
    slips = std::abs(off) > kSlip_rad + 4 * u ? slips + 1 : 0;
    since_in_phase = std::abs(off) > kInPhase_rad + 4 * u ? since_in_phase + 1 : 0;
    return slips >= 2;
  }

  void arm(int from) {
    ++index;
    enter(State::settling);
    restarts = 0;
    begin_hold(from);
    start_ns = steady_ns;
  }

  // The drive is taken as steady from block `from` on.
  void begin_hold(int from) {
    steady_ns = blocks.block(from).begin_ns;
    steady_serial = blocks.block(from).first_serial;
    blocks.forget_before(steady_ns);
    time_constant_s = kNaN;
    solve_at_serial = 0;
    verdict = {};
    verdict.settles_in_s = kNaN;
    counted_valid = false;
    settling.restart();
    history_omega = omega;
    slips = since_in_phase = 0;
    drive.restart();
    for (Live& channel : live) {
      channel.half_ns_sum = channel.half_count = 0.0;
      channel.step = INFINITY;
      channel.overrange = 0;
    }
    if (tracked()) omega = std::isfinite(omega) ? omega : kTwoPi * rig.excitation.frequency_hz;
  }

  // The drive is another than in this hold. Whether it changed or stopped shows when the change has passed through the
  // window; until then the finished dwell is kept back.
  void change(int from) {
    if (state == State::measuring) {
      // The dwell ends with the last window that was beyond doubt, and a quarter before it: two periods back at most by
      // the amplitude, as far as the phase has been slipping away by that.
      const int back = std::max(std::min(drive.windows_since_good() + 1, 2 * kQuarters + 1),
                                std::min(since_in_phase + 1, Blocks::kFine - 2 * kQuarters));
      conclude(std::max(0, blocks.count() - back), false);
      pending_until_serial = blocks.serials() + kLongestPending;
      if (tracked()) omega = kTwoPi * rig.excitation.frequency_hz;
      return arm(from);
    }
    ++restarts;
    begin_hold(from);
    start_ns = steady_ns;
  }

  void stop() {
    if (pending) {
      --index;  // what was armed after the change was no dwell
      emit(EndedBy::drive_stopped);
    } else if (state == State::settling || state == State::measuring) {
      const int back = std::min(kQuarters * window_periods + drive.windows_since_good() + 2, blocks.count());
      conclude(blocks.count() - back, false);
      emit(EndedBy::drive_stopped);
    }
    enter(State::idle);
    omega = kTwoPi * rig.excitation.frequency_hz;
  }

  // Ends the run of dwells for another reason than the drive.
  void end(EndedBy ended_by, State next, bool with_open) {
    if (pending) {
      --index;
      emit(EndedBy::drive_changed);
    } else if (state == State::settling || state == State::measuring) {
      // Windows in doubt do not count, whatever ends the dwell.
      const int doubtful =
          drive.windows_since_good() > 0 ? std::min(drive.windows_since_good() + 1, blocks.count()) : 0;
      conclude(blocks.count() - doubtful, with_open && doubtful == 0);
      emit(ended_by);
    }
    enter(next);
  }
  void lose_data() {
    end(EndedBy::data_lost, State::fault, false);
    // Another transducer of the table's motion, if it has one, shows the drive from now on.
    for (int c = 0; c < channel_count; ++c)
      if (shows_drive(rig.channels[static_cast<std::size_t>(c)]) && delivers(c)) {
        drive_channel = c;
        break;
      }
  }
  void rearm() {
    if (state == State::settling || state == State::measuring) end(EndedBy::drive_changed, State::idle, false);
  }

  // While nothing is measured the means may be taken anew, so that they never cost digits however long the service
  // runs.
  void refresh_reference() {
    if (blocks.count() < kEmptyBlocks) return;
    blocks.clear();
    for (int c = 0; c < channel_count; ++c)
      blocks.set_reference(c, std::isfinite(live[static_cast<std::size_t>(c)].now.value)
                                  ? live[static_cast<std::size_t>(c)].now.value
                                  : 0.0);
  }

  // Windows are compared with each other, so all are taken at one ω: when the best known has moved by a part of the
  // tolerance that would show, those of this hold are taken anew.
  void settle(std::int64_t end_ns) {
    const int quarters = kQuarters * window_periods, newest = blocks.count();
    int first = newest;
    if (std::abs(omega / history_omega - 1) > 0.2 * rig.tolerance &&
        blocks.serials() - steady_serial <= Blocks::kFine) {
      settling.restart();
      history_omega = omega;
      first = std::max(blocks.index_of(steady_serial) + quarters, quarters);
    }
    for (int to = first; to <= newest; ++to)
      if (!look(to - quarters, to)) return;
    if (!verdict.settled || out_of_search()) return;
    const int counts_from = blocks.index_of(verdict.from_serial);
    if (counts_from >= blocks.count()) return;
    settled_ns = blocks.block(counts_from).begin_ns;
    blocks.forget_before(settled_ns);
    verdict_ns = end_ns;
    enter(State::measuring);
    for (int c = 0; c < channel_count; ++c) transient[static_cast<std::size_t>(c)] = settling.left(c);
    count_anew();
  }

  // Shows the detector the window of blocks [from, to). false: it could not be fitted.
  bool look(int from, int to) {
    const std::int64_t begin_ns = blocks.block(from).begin_ns, end_ns = blocks.block(to - 1).end_ns;
    blocks.sum(from, to, omega, begin_ns + (end_ns - begin_ns) / 2, window);
    for (int c = 0; c < channel_count; ++c)
      fits[static_cast<std::size_t>(c)] = fit_harmonics(window, c, H, blocks.reference(c));
    const HarmonicFit& table = fits[static_cast<std::size_t>(drive_channel)];
    if (!table.usable) return false;
    const Complex back = std::conj(table.X[0]) / std::abs(table.X[0]);
    const double u_table = std::sqrt(0.5 * table.covariance.trace()) / std::abs(table.X[0]);
    for (int c = 0; c < channel_count; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const HarmonicFit& fit = fits[i];
      const bool watched = rig.channels[i].measures != Quantity::auxiliary && delivers(c) && !stuck(live[i]);
      if (watched && !fit.usable && window_periods == 1 && fit.samples >= 2 * H + 1) {
        window_periods = 2;
        return false;
      }
      const double noise = watched && fit.usable ? noise_variance(c, from, to, fit.sigma2) : 0.0;
      const double u = std::sqrt(0.5 * fit.covariance.trace() * (fit.sigma2 > 0 ? noise / fit.sigma2 : 1.0));
      // Relative to the table's phase, whose own noise comes on top.
      readings[i] = {fit.X[0] * back,      {},    std::hypot(u, std::abs(fit.X[0]) * u_table),
                     fit.sigma2,           noise, fit.samples,
                     watched && fit.usable};
      readings[i].others[0] = fit.mean;
      Complex turn = back;
      for (std::size_t h = 1; h < static_cast<std::size_t>(H); ++h) readings[i].others[h] = fit.X[h] * (turn *= back);
    }
    provisional();
    const double amplitude = std::abs(table.X[0]);
    verdict = settling.update(blocks.block(from).first_serial, blocks.block(to - 1).first_serial, axis_s(end_ns),
                              amplitude, u_table * amplitude, readings, period_s() * window_periods, time_constant_s);
    return true;
  }

  // The noise of a channel in blocks [from, to), whatever else it does: in each quarter of a period a mean, a sine and
  // a cosine follow any smooth motion, and what they leave is noise. Where too few samples allow that, all that the
  // harmonic fit leaves.
  double noise_variance(int c, int from, int to, double otherwise) {
    double squares = 0.0, freedom = 0.0;
    for (int i = from; i < to; ++i) {
      blocks.sum_channel(c, i, i + 1, blocks.block(i).omega, blocks.block(i).centre_ns, quarter);
      const HarmonicFit fit = fit_harmonics(quarter, c, 1, 0.0);
      if (!std::isfinite(fit.sigma2)) continue;
      squares += fit.sigma2 * (fit.samples - 3);
      freedom += fit.samples - 3;
    }
    return freedom >= 4 ? std::min(otherwise, squares / freedom) : otherwise;
  }

  [[nodiscard]] bool out_of_search() const {
    const double f = drive.omega() / kTwoPi;
    return tracked() && std::isfinite(f) && (f < rig.excitation.search_low_hz || f > rig.excitation.search_high_hz);
  }

  // Coefficients from the later half of the hold so far, for the decay that they predict: for a chain of which every
  // channel delivers, now and then (the eigenvalues cost n³).
  void provisional() {
    if (rig.mass_count() > kLargestSolved || blocks.serials() < solve_at_serial) return;
    solve_at_serial = blocks.serials() + std::max<std::int64_t>(1, (blocks.serials() - steady_serial) / 32);
    time_constant_s = kNaN;
    for (int c = 0; c < channel_count; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (rig.channels[i].measures != Quantity::auxiliary && !readings[i].usable) return;
      const Complex seen = settling.later_mean(c);
      observed(c) =
          readings[i].usable ? as_observed(rig, c, seen != 0.0 ? seen : readings[i].relative, omega, 1) : Complex{};
    }
    state_x.noalias() = provisional_gain.gain * observed;
    const int n = rig.mass_count();
    Y[0] = state_x(0);
    for (int k = 1; k <= n; ++k) {
      d[static_cast<std::size_t>(k - 1)] = state_x(k);
      Y[static_cast<std::size_t>(k)] = Y[static_cast<std::size_t>(k - 1)] + state_x(k);
    }
    identify(rig.boundary, rig.masses, omega, Y, d, state_x(n + 1), Z);
    time_constant_s = decay.time_constant_s(Z, omega);
  }

  // ω and the running sums from all data that count: at the verdict, whenever the data have grown by a sixth, and when
  // the oldest have been forgotten.
  void count_anew() {
    counted_valid = false;
    if (blocks.count() == 0) return;
    double u_omega = 0.0;
    for (int i = 0; i < kTurns; ++i) {
      blocks.sum(0, blocks.count(), omega, blocks.block(0).begin_ns, counted);
      const Refined refined = refine(rig, counted, drive_channel, totals);
      omega = refined.omega;
      u_omega = refined.u;
      if (refined.reached) break;
    }
    if (drop_misjudged()) return count_anew();
    // Once more about the centroid, where turning costs least.
    const std::int64_t centroid_ns = counted.centroid_ns(drive_channel);
    blocks.sum(0, blocks.count(), omega, centroid_ns, counted);
    counted_valid = true;
    const Complex X = fit_harmonics(counted, drive_channel, H, 0.0).X[0];
    hold = {centroid_ns, std::arg(X), omega, u_omega};
    drive.refer(std::abs(as_observed(rig, drive_channel, X, omega, 1)), omega);
    const std::int64_t first = blocks.block(0).first_serial;
    refine_at_serial = first + static_cast<std::int64_t>(kGrowth * static_cast<double>(blocks.serials() - first)) + 1;
  }

  // The first blocks of a hold may have been taken before its frequency was known; turning them loses (δu)²/6. Where
  // that is no small part of the uncertainty they go, if they are no large part of the data.
  bool drop_misjudged() {
    const std::int64_t first = blocks.block(0).first_serial, all = blocks.serials() - first;
    if (all < kEnoughQuarters) return false;
    double loss = 0.0;
    std::int64_t good_from_ns = 0;
    for (int i = 0; i < blocks.count(); ++i) {
      const Blocks::Block& block = blocks.block(i);
      const double turned = (block.omega / omega - 1) * std::numbers::pi / 4;
      loss += turned * turned / 6 * block.quarters / static_cast<double>(all);
      if (block.first_serial - first <= all / 8 && std::abs(block.omega / omega - 1) > kMisjudged)
        good_from_ns = block.end_ns;
    }
    const HarmonicFit fit = fit_harmonics(totals, drive_channel, H, 0.0);
    if (good_from_ns == 0 || !(loss * std::abs(fit.X[0]) > 0.1 * std::sqrt(0.5 * fit.covariance.trace()))) return false;
    return blocks.forget_before(good_from_ns);
  }

  // The sums over blocks [from, to) and the open one, refined: leaves them in `totals`.
  Refined gather(int from, int to, bool with_open) const {
    Refined refined{omega, 0.0, false};
    for (int i = 0; i < kTurns && !refined.reached; ++i) {
      if (i == 0 && from == 0 && to == blocks.count() && counted_valid)
        counted.turned(counted.omega(), counted.t_ref_ns(), gathered);
      else
        blocks.sum(from, to, refined.omega, from < to ? blocks.block(from).begin_ns : now_ns, gathered);
      if (with_open) blocks.add_open(gathered);
      refined = refine(rig, gathered, drive_channel, totals);
    }
    return refined;
  }

  void conclude(int to, bool with_open) {
    finished = evaluate(to, with_open, false);
    finished_omega = omega;
    finished.state = State::complete;
    finished.settles_in_s = kNaN;
    pending = true;
  }

  void emit(EndedBy ended_by) {
    pending = false;
    // What never settled and was hardly begun was no dwell.
    if (!std::isfinite(finished.settled_s) && ended_by != EndedBy::end &&
        to_s(now_ns - start_ns) < kShortest * kTwoPi / finished_omega) {
      --index;
      return;
    }
    finished.ended_by = ended_by;
    changes |= kCompleted;
  }

  // Blocks up to `to`. up_to_now: a channel that does not deliver now is withheld; a dwell that has ended keeps what it
  // had.
  [[nodiscard]] Dwell evaluate(int to, bool with_open, bool up_to_now) const;
  [[nodiscard]] std::string settling_reason() const;
  [[nodiscard]] ChannelResult result_of(int c, bool up_to_now) const;
  void widen(ChannelResult& result, int c, int from, int to, Dwell& dwell) const;
};

std::string Pipeline::Impl::settling_reason() const {
  if (sparse)
    return rig.channels[static_cast<std::size_t>(drive_channel)].name + " has too few samples a period for " +
           std::to_string(H) + " harmonics: at least " + std::to_string(2 * (H + 1)) + " are needed";
  if (state == State::idle) return "the table does not move by more than the minimum";
  if (state == State::fault) {
    const Live& table = live[static_cast<std::size_t>(drive_channel)];
    return "the drive is not seen: " + rig.channels[static_cast<std::size_t>(drive_channel)].name + " is " +
           to_string(table.now.fault == Fault::none ? Fault::silent : table.now.fault);
  }
  if (out_of_search())
    return "the drive is at " + std::to_string(drive.omega() / kTwoPi) + " Hz, outside the range that is searched";
  if (state == State::settling) {
    if (restarts >= kManyRestarts)
      return "the drive is not steady, or not at a frequency between " +
             std::to_string(rig.excitation.search_low_hz).substr(0, 6) + " and " +
             std::to_string(rig.excitation.search_high_hz).substr(0, 6) + " Hz";
    if (verdict.worst_channel >= 0 && verdict.worst_left > 1) {
      const std::string times = std::to_string(verdict.worst_left);
      return "transient left in " + rig.channels[static_cast<std::size_t>(verdict.worst_channel)].name + ": " +
             times.substr(0, times.find('.') + 2) + " times what is allowed" +
             (rig.mass_count() > 0 && !std::isfinite(time_constant_s) &&
                      blocks.serials() - steady_serial > 10 * kQuarters
                  ? "; the coefficients so far are not those of a chain that decays: look at signs, order and masses"
                  : "");
    }
    return "too few periods seen";
  }
  return "the windows since " + std::to_string(axis_s(settled_ns)).substr(0, 8) + " s agree";
}

ChannelResult Pipeline::Impl::result_of(int c, bool up_to_now) const {
  const Live& channel = live[static_cast<std::size_t>(c)];
  ChannelResult result;
  result.fit = fit_harmonics(totals, c, H, blocks.reference(c));
  result.dof = result.fit.samples - (2 * H + 1);
  if (stuck(channel))
    result.withheld = "stuck at one reading";
  else if (up_to_now && !delivers(c))
    result.withheld =
        channel.last_ns == INT64_MIN && channel.now.fault == Fault::silent
            ? "no sample yet"
            : std::string("stale, ") + to_string(channel.now.fault == Fault::none ? Fault::silent : channel.now.fault);
  if (state == State::measuring && transient[static_cast<std::size_t>(c)] > 0 && std::isfinite(time_constant_s)) {
    // Decaying with T over the D that count, its mean is T/D (1 - exp(-D/T)) of what it began with, taken as
    // rectangular.
    const double D = std::max(to_s(now_ns - settled_ns), 1e-9);
    result.transient_u = transient[static_cast<std::size_t>(c)] * time_constant_s / D *
                         -std::expm1(-D / time_constant_s) / std::numbers::sqrt3;
  }
  // Without noise of half a step to smooth it, rounding repeats with the motion when the sampling rate is near a
  // multiple of the frequency: no more independent errors then than one period has samples.
  if (result.fit.usable && std::isfinite(channel.step) &&
      result.fit.sigma2 < channel.step * channel.step * (0.25 + 1.0 / 12)) {
    const double span_s = std::sqrt(12 * moments::mean_square_u(totals.channel(c).instants, 2 * H + 1));
    const double in_period = std::max(1.0, result.fit.samples * std::min(1.0, period_s() / std::max(span_s, 1e-9)));
    result.quantization_u = channel.step / std::sqrt(12.0) * std::sqrt(2 / in_period);
  }
  if (channel.half_count > 0)
    result.turnaround_u_s = channel.half_ns_sum / channel.half_count * 1e-9 / std::numbers::sqrt3;
  return result;
}

// Residuals that hang together make the phasor less certain than white ones would.
void Pipeline::Impl::widen(ChannelResult& result, int c, int from, int to, Dwell& dwell) const {
  const Scatter scatter = phasor_scatter(blocks, from, to, c, H, result.fit, totals.omega(), totals.t_ref_ns(), window);
  if (!(scatter.dof > 0) || scatter.ratio < 1 + kSureOfScatter * std::sqrt(2 / scatter.dof)) return;
  // What varies by many times its noise does not do so independently from stretch to stretch: then the spread of the
  // stretches is the uncertainty, not that of their mean.
  result.fit.covariance *= scatter.ratio * (scatter.ratio > kUnsteady ? scatter.dof / 2 + 1 : 1.0);
  result.dof = scatter.dof;
  // Told where it is many times the noise and a part of the amplitude that matters.
  const double varies = std::sqrt(0.5 * result.fit.covariance.trace());
  if (scatter.ratio > kUnsteady && varies > 0.1 * rig.tolerance * std::abs(result.fit.X[0]) &&
      result.withheld.empty()) {
    const std::string times = std::to_string(std::sqrt(scatter.ratio));
    dwell.warnings.push_back(rig.channels[static_cast<std::size_t>(c)].name + " is not steady: its phasor varies " +
                             times.substr(0, times.find('.') + 2) + " times as much as its noise explains");
  }
}

Dwell Pipeline::Impl::evaluate(int to, bool with_open, bool up_to_now) const {
  Dwell dwell;
  dwell.state = state;
  dwell.memory_time_predicted_s = std::isfinite(time_constant_s) ? -time_constant_s * std::log(rig.tolerance) : kNaN;
  dwell.settling_reason = settling_reason();
  if (origin_ns == INT64_MIN) return dwell;
  const bool active = state == State::settling || state == State::measuring;
  if (active) {
    dwell.index = index;
    dwell.start_s = axis_s(start_ns);
  }
  int quarters_left = 0;
  for (int i = 0; i < to; ++i) quarters_left += blocks.block(i).quarters;
  const bool settled = state == State::measuring && quarters_left >= kFewestQuarters;
  const int from = settled ? 0 : std::max(0, to - kQuarters * window_periods);
  const auto [w, u, reached] = gather(from, to, with_open);
  dwell.t_ref_s = axis_s(totals.t_ref_ns());
  std::vector<ChannelResult> results;
  for (int c = 0; c < channel_count; ++c) {
    results.push_back(result_of(c, up_to_now));
    if (settled) widen(results.back(), c, from, to, dwell);
  }
  report_phasors(rig, results, w, u, dwell);
  if (!active) dwell.frequency_hz = {};
  dwell.end_s = axis_s(with_open || to == 0 ? last_sample_ns : std::min(last_sample_ns, blocks.block(to - 1).end_ns));
  for (int c = 0; c < channel_count; ++c) {
    const Live& channel = live[static_cast<std::size_t>(c)];
    if (channel.overrange > 0)
      dwell.warnings.push_back(rig.channels[static_cast<std::size_t>(c)].name + ": " +
                               std::to_string(channel.overrange) + " readings beyond its range were left out");
  }
  if (!settled) {
    if (state == State::measuring) {
      dwell.settling_reason = "too little is left of the dwell beside what may have been taken while the drive changed";
      dwell.warnings.push_back("not settled: " + dwell.settling_reason);
    } else if (active) {
      dwell.settles_in_s = verdict.settles_in_s;
      dwell.warnings.push_back("not settled: " + dwell.settling_reason);
    }
    return dwell;
  }
  dwell.settled_s = axis_s(std::max(settled_ns, blocks.count() > 0 ? blocks.block(0).begin_ns : settled_ns));
  dwell.verdict_s = axis_s(verdict_ns);
  dwell.memory_time_s = axis_s(settled_ns) - axis_s(steady_ns);
  dwell.settles_in_s = 0.0;
  if (rig.mass_count() > 0 && !std::isfinite(time_constant_s))
    dwell.warnings.push_back(
        "the chain identified while settling would not decay: whether the transient has is judged by "
        "the windows alone; look at signs, instants and masses");
  report_elements(rig, G, results, w, u, dwell);
  return dwell;
}

Pipeline::Pipeline(const Rig& rig) : impl_(std::make_unique<Impl>(rig)) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

std::uint8_t Pipeline::push(const Record& record) noexcept { return impl_->push(record); }

std::uint8_t Pipeline::finish() {
  impl_->changes = kNothing;
  impl_->end(EndedBy::end, State::idle, true);
  return impl_->changes;
}

Dwell Pipeline::current() const { return impl_->evaluate(impl_->blocks.count(), true, true); }
const Dwell& Pipeline::completed() const noexcept { return impl_->finished; }
State Pipeline::state() const noexcept { return impl_->state; }

std::complex<double> Pipeline::phasor(int channel) const noexcept {
  const Impl& p = *impl_;
  if (p.origin_ns == INT64_MIN) return {kNaN, kNaN};
  const int to = p.blocks.count();
  const int from = p.state == State::measuring ? 0 : std::max(0, to - kQuarters * p.window_periods);
  if (p.state == State::measuring && p.counted_valid)
    p.counted.turned(p.omega, p.now_ns, p.window);
  else
    p.blocks.sum(from, to, p.omega, p.now_ns, p.window);
  p.blocks.add_open(p.window);
  const HarmonicFit fit = fit_harmonics(p.window, channel, p.H, 0.0);
  const Channel& about = p.rig.channels[static_cast<std::size_t>(channel)];
  const double delay = about.device >= 0 ? p.rig.devices[static_cast<std::size_t>(about.device)].delay_s : 0.0;
  return fit.usable ? fit.X[0] / response(about, delay, p.omega / kTwoPi) : std::complex<double>{kNaN, kNaN};
}

ChannelNow Pipeline::channel(int channel) const noexcept { return impl_->live[static_cast<std::size_t>(channel)].now; }

}  // namespace dwell
