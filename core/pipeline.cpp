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
#include "core/settling.hpp"
#include "core/transducer.hpp"

namespace dwell {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr int kQuarters = 4;               // windows of one period
constexpr std::int64_t kEmptyBlocks = 64;  // without a record: the time between is skipped, not stepped through
constexpr double kLostPeriods = 2.0;       // without a sample, and at least kLost_s: a channel no longer delivers
constexpr double kLost_s = 1.0;
constexpr double kOverGain = 1.15;  // the data grow by this factor before ω is refined again

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
        totals(channel_count, H),
        settling(channel_count, given.tolerance),
        drive(given.tolerance),
        decay(given.boundary, given.masses),
        G(observation_matrix(given)),
        omega(kTwoPi * given.excitation.frequency_hz) {
    live.resize(static_cast<std::size_t>(channel_count));
    fits.resize(live.size());
    readings.resize(live.size());
    for (int c = 0; c < channel_count; ++c) {
      const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
      Live& delivering = live[static_cast<std::size_t>(c)];
      delivering.gain = channel.si_per_unit * channel.scale;
      delivering.offset = channel.si_per_unit * channel.offset;
      delivering.low = channel.range_low.value_or(-INFINITY) * channel.si_per_unit;
      delivering.high = channel.range_high.value_or(INFINITY) * channel.si_per_unit;
      const bool motion = channel.measures != Quantity::force && channel.measures != Quantity::auxiliary;
      if (motion && channel.at == 0 && !channel.relative_to && drive_channel < 0) drive_channel = c;
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
    std::int64_t last_ns = INT64_MIN;
    double half_ns_sum = 0.0, half_count = 0.0;  // of this dwell
    std::uint64_t rejected_before = 0, overrange = 0;
    bool referenced = false;
  };

  const Rig rig;
  const int channel_count, H;
  Blocks blocks;
  mutable Totals window, totals;
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
  Eigen::VectorXd weights;  // of this dwell, from its verdict on

  State state = State::idle;
  double omega;  // rad/s, best known
  std::int64_t origin_ns = INT64_MIN, now_ns = INT64_MIN, last_sample_ns = INT64_MIN;
  int index = 0, low_windows = 0, window_periods = 1;
  std::int64_t start_ns = 0, steady_ns = 0, settled_ns = 0, verdict_ns = 0;
  double time_constant_s = kNaN;
  SettlingDetector::Verdict verdict;
  std::int64_t steady_serial = 0, refine_at_serial = 0;
  Dwell finished;
  bool pending = false;  // `finished` awaits its reason
  std::int64_t pending_until_serial = 0;
  std::uint8_t changes = kNothing;

  [[nodiscard]] bool tracked() const { return rig.excitation.reference != Reference::fixed; }
  [[nodiscard]] double axis_s(std::int64_t ns) const { return to_s(ns - origin_ns); }
  [[nodiscard]] double period_s() const { return kTwoPi / omega; }

  void enter(State next) {
    if (next != state) changes |= kStateChanged;
    state = next;
  }

  // ---- the stream -------------------------------------------------------------------------------------------------

  std::uint8_t push(const Record& record) {
    changes = kNothing;
    if (origin_ns == INT64_MIN) {
      origin_ns = now_ns = record.t_ns;
    }
    if (record.t_ns < now_ns) {  // not in order: counted where there is something to count
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
    channel.now.value = value;
    channel.now.t_ns = record.t_ns;
    channel.now.fault = Fault::none;
    channel.now.overrange = value < channel.low || value > channel.high;
    if (channel.now.overrange) {
      ++channel.now.rejected;
      ++channel.overrange;
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

  // ---- once per quarter of a period -------------------------------------------------------------------------------

  void on_block(std::int64_t end_ns) {
    blocks.forget_before(end_ns - to_ns(rig.memory_s));
    const int quarters = kQuarters * window_periods;
    if (blocks.count() < quarters) return;
    const int from = blocks.count() - quarters, to = blocks.count();
    const std::int64_t begin_ns = blocks.block(from).begin_ns;
    const std::int64_t centre_ns = begin_ns + (end_ns - begin_ns) / 2;

    // Before a period has shown the drive's frequency by its phase, the window itself tells it well enough that the
    // first windows do not differ from the later ones for their frequency alone.
    if (tracked() && !std::isfinite(drive.omega())) acquire(from, to, centre_ns);
    blocks.sum_channel(drive_channel, from, to, false, omega, centre_ns, window);
    const HarmonicFit table = fit_harmonics(window, drive_channel, H, blocks.reference(drive_channel));
    if (!delivers(drive_channel)) return lose_data();
    if (!table.usable) {
      // So few samples a period that one alone cannot be solved: look at two.
      if (window_periods == 1 && table.samples >= 2 * H + 1) window_periods = 2;
      return;
    }
    const Complex Y0 = as_observed(rig, drive_channel, table.X[0], omega, 1);
    const double per_reading = std::abs(Y0) / std::max(std::abs(table.X[0]), 1e-300);
    const double u0 = std::sqrt(0.5 * table.covariance.trace()) * per_reading;

    if (pending && blocks.serials() >= pending_until_serial) emit(EndedBy::drive_changed);
    if (std::abs(Y0) < rig.excitation.minimum || std::abs(Y0) < 3 * u0) {
      if (++low_windows >= 2) stop();
      if (state == State::idle || state == State::fault) refresh_reference();
      return;
    }
    low_windows = 0;
    if (state == State::idle || state == State::fault) arm(from);
    if (drive.update(to_s(centre_ns - steady_ns), Y0, u0, omega)) return change(from);
    if (state == State::settling) {
      if (tracked() && std::isfinite(drive.omega())) omega = searched(drive.omega());
      blocks.sum(blocks.count() - quarters, blocks.count(), false, omega, centre_ns, window);
      settle(blocks.count() - quarters, end_ns, table, Y0, u0);
    } else if (state == State::measuring && blocks.serials() >= refine_at_serial) {
      refine();
    }
  }

  // ω from one window of the drive channel, where that is known to a hundredth.
  void acquire(int from, int to, std::int64_t centre_ns) {
    double w = kTwoPi * rig.excitation.frequency_hz, information = 0.0;
    for (int step = 0; step < 4; ++step) {
      blocks.sum_channel(drive_channel, from, to, false, w, centre_ns, window);
      const HarmonicFit fit = fit_harmonics(window, drive_channel, H, blocks.reference(drive_channel));
      if (!(fit.information > 0)) return;
      information = fit.information;
      w = searched(w + fit.score / fit.information);
    }
    if (1 / std::sqrt(information) < 1e-2 * w) omega = w;
  }

  [[nodiscard]] double searched(double w) const {
    return std::clamp(w, kTwoPi * rig.excitation.search_low_hz, kTwoPi * rig.excitation.search_high_hz);
  }

  // A channel delivers while no fault is known of it and its newest sample is not too old.
  [[nodiscard]] bool delivers(int c) const {
    const Live& channel = live[static_cast<std::size_t>(c)];
    return channel.now.fault == Fault::none && channel.last_ns != INT64_MIN &&
           to_s(now_ns - channel.last_ns) <= std::max(kLost_s, kLostPeriods * period_s());
  }

  void arm(int from) {
    ++index;
    enter(State::settling);
    begin_hold(from);
    start_ns = steady_ns;
  }

  // The drive is taken as steady from block `from` on.
  void begin_hold(int from) {
    steady_ns = blocks.block(from).begin_ns;
    steady_serial = blocks.block(from).first_serial;
    blocks.forget_before(steady_ns);
    time_constant_s = kNaN;
    verdict = {};
    verdict.settles_in_s = kNaN;
    settling.restart();
    drive.restart();
    for (Live& channel : live) {
      channel.half_ns_sum = channel.half_count = 0.0;
      channel.overrange = 0;
    }
    if (tracked()) omega = std::isfinite(omega) ? omega : kTwoPi * rig.excitation.frequency_hz;
  }

  // The drive is another than in this hold. Whether it changed or stopped shows when the change has passed through the
  // window; until then the finished dwell is kept back.
  void change(int from) {
    if (state == State::measuring) {
      // The dwell ends with the last window that was beyond doubt, and a quarter before it: two periods back at most.
      const int back = std::min(drive.windows_since_good() + 1, 2 * kQuarters + 1);
      conclude(std::max(0, blocks.count() - back), false);
      pending_until_serial = blocks.serials() + kQuarters * window_periods + 1;
      if (tracked()) omega = kTwoPi * rig.excitation.frequency_hz;
      return arm(from);
    }
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
      conclude(blocks.count(), with_open);
      emit(ended_by);
    }
    enter(next);
  }
  void lose_data() { end(EndedBy::data_lost, State::fault, false); }
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

  // ---- settling ---------------------------------------------------------------------------------------------------

  void settle(int from, std::int64_t end_ns, const HarmonicFit& table, Complex Y0, double u0) {
    const Complex back = std::conj(Y0) / std::abs(Y0);
    for (int c = 0; c < channel_count; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const bool watched = rig.channels[i].measures != Quantity::auxiliary && delivers(c);
      fits[i] = c == drive_channel ? table : fit_harmonics(window, c, H, blocks.reference(c));
      const HarmonicFit& fit = fits[i];
      if (watched && !fit.usable && window_periods == 1 && fit.samples >= 2 * H + 1) {
        window_periods = 2;
        return;
      }
      const double u = std::sqrt(0.5 * fit.covariance.trace());
      // Relative to the table's phase, whose own noise comes on top.
      readings[i] = {fit.X[0] * back, std::hypot(u, std::abs(fit.X[0]) * u0 / std::abs(Y0)), fit.sigma2, fit.samples,
                     watched && fit.usable};
    }
    provisional();
    verdict = settling.update(blocks.block(from).first_serial, blocks.serials() - 1, axis_s(end_ns), std::abs(Y0), u0,
                              readings, period_s() * window_periods, time_constant_s);
    if (!verdict.settled || out_of_search()) return;
    const int first = blocks.index_of(verdict.from_serial);
    if (first >= blocks.count()) return;
    settled_ns = blocks.block(first).begin_ns;
    blocks.forget_before(settled_ns);
    verdict_ns = end_ns;
    enter(State::measuring);
    refine();
  }

  [[nodiscard]] bool out_of_search() const {
    const double f = drive.omega() / kTwoPi;
    return tracked() && std::isfinite(f) && (f < rig.excitation.search_low_hz || f > rig.excitation.search_high_hz);
  }

  // Coefficients from the newest window alone, for the decay that they predict.
  void provisional() {
    for (int c = 0; c < channel_count; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (rig.channels[i].measures != Quantity::auxiliary && !readings[i].usable) return;
      observed(c) = readings[i].usable ? as_observed(rig, c, fits[i].X[0], omega, 1) : Complex{};
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

  // ---- the frequency ----------------------------------------------------------------------------------------------

  // Gauss-Newton on ω over all blocks from `from` to `to`, all channels of motion and force together. Returns the
  // standard uncertainty (rad/s); leaves `totals` at the refined ω about the centroid of the drive channel's samples.
  double sum_refined(int from, int to, bool with_open, double& w) const {
    const bool search = tracked();
    std::int64_t t_ref = blocks.count() > from ? blocks.block(from).begin_ns : now_ns;
    double information = 0.0;
    for (int step = 0;; ++step) {
      blocks.sum(from, to, with_open, w, t_ref, totals);
      const ChannelMoments sums = totals.channel(drive_channel);
      if (step == 0 && sums.instants[0] > 0) {
        t_ref += to_ns(sums.instants[moments::cosine(2 * H + 1, 1, 0)] / sums.instants[0]);
        continue;
      }
      if (!search || step > 6) break;
      double score = 0.0;
      information = 0.0;
      for (int c = 0; c < channel_count; ++c) {
        if (rig.channels[static_cast<std::size_t>(c)].measures == Quantity::auxiliary) continue;
        const HarmonicFit fit = fit_harmonics(totals, c, H, blocks.reference(c));
        if (!fit.usable) continue;
        score += fit.score;
        information += fit.information;
      }
      if (!(information > 0)) break;
      const double delta = score / information;
      // A step that turns the ends of the data by less than a hundredth of their uncertainty changes nothing.
      if (std::abs(delta) * std::sqrt(information) < 1e-2 || std::abs(delta) < 1e-14 * w) break;
      w = searched(w + delta);
    }
    return information > 0 ? 1 / std::sqrt(information) : kTwoPi * rig.excitation.frequency_u_hz;
  }

  void refine() {
    if (tracked()) sum_refined(0, blocks.count(), false, omega);
    const std::int64_t counted = blocks.serials() - blocks.block(0).first_serial;
    refine_at_serial =
        blocks.block(0).first_serial + static_cast<std::int64_t>(kOverGain * static_cast<double>(counted)) + 1;
  }

  // ---- results ----------------------------------------------------------------------------------------------------

  void conclude(int to, bool with_open) {
    finished = evaluate(to, with_open, false);
    finished.state = State::complete;
    finished.settles_in_s = kNaN;
    pending = true;
  }

  void emit(EndedBy ended_by) {
    finished.ended_by = ended_by;
    pending = false;
    changes |= kCompleted;
  }

  // up_to_now: a channel that does not deliver now is withdrawn; a dwell that has ended keeps what it had.
  [[nodiscard]] Dwell evaluate(int to, bool with_open, bool up_to_now) const;
  [[nodiscard]] std::string settling_reason() const;
  [[nodiscard]] std::vector<Evidence> gather_evidence(bool up_to_now) const;
  void fill_phasors(Dwell& dwell, double w, const std::vector<Evidence>& evidence) const;
};

std::string Pipeline::Impl::settling_reason() const {
  if (state == State::idle) return "the table does not move by more than the minimum";
  if (state == State::fault) {
    const Live& table = live[static_cast<std::size_t>(drive_channel)];
    return "the drive is not seen: " + rig.channels[static_cast<std::size_t>(drive_channel)].name + " is " +
           to_string(table.now.fault == Fault::none ? Fault::silent : table.now.fault);
  }
  if (out_of_search())
    return "the drive is at " + std::to_string(drive.omega() / kTwoPi) + " Hz, outside the range that is searched";
  if (state == State::settling) {
    if (verdict.worst_channel >= 0 && verdict.worst_left > 1) {
      const double percent = 100 * verdict.worst_left * rig.tolerance;
      const std::string number = std::to_string(percent);
      return "transient left in " + rig.channels[static_cast<std::size_t>(verdict.worst_channel)].name + ": " +
             number.substr(0, number.find('.') + 3) + " % of what is allowed times 1/tolerance";
    }
    return "too few periods seen";
  }
  return "the windows since " + std::to_string(axis_s(settled_ns)).substr(0, 8) + " s agree";
}

std::vector<Evidence> Pipeline::Impl::gather_evidence(bool up_to_now) const {
  std::vector<Evidence> evidence(live.size());
  for (int c = 0; c < channel_count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const HarmonicFit fit = fit_harmonics(totals, c, H, blocks.reference(c));
    Evidence& out = evidence[i];
    const Live& channel = live[i];
    if (up_to_now && !delivers(c)) {
      out.reason = channel.last_ns == INT64_MIN && channel.now.fault == Fault::silent
                       ? "no sample yet"
                       : std::string("stale, ") +
                             to_string(channel.now.fault == Fault::none ? Fault::silent : channel.now.fault);
    } else if (!fit.usable) {
      out.reason = "too few samples in the data that count";
    } else {
      out.usable = true;
    }
    out.X = fit.X;
    out.covariance = fit.covariance;
    out.dof = fit.samples - (2 * H + 1);
    out.turnaround_u_s =
        channel.half_count > 0 ? channel.half_ns_sum / channel.half_count * 1e-9 / std::numbers::sqrt3 : 0.0;
  }
  return evidence;
}

void Pipeline::Impl::fill_phasors(Dwell& dwell, double w, const std::vector<Evidence>& evidence) const {
  for (int c = 0; c < channel_count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const Channel& channel = rig.channels[i];
    const HarmonicFit fit = fit_harmonics(totals, c, H, blocks.reference(c));
    ChannelPhasor out;
    out.valid = evidence[i].usable;
    out.reason = evidence[i].reason;
    out.samples = fit.samples;
    if (fit.usable) {
      const double delay = channel.device >= 0 ? rig.devices[static_cast<std::size_t>(channel.device)].delay_s : 0.0;
      const Complex response_1 = response(channel, delay, w / kTwoPi);
      out.Y = fit.X[0] / response_1;
      out.mean = fit.mean;
      out.sigma = std::sqrt(fit.sigma2);
      const double amplitude = std::abs(fit.X[0]);
      // The covariance along the phasor and across it.
      const Eigen::Vector2d along(fit.X[0].real() / amplitude, fit.X[0].imag() / amplitude),
          across(-along(1), along(0));
      const double u_along = std::sqrt(along.dot(fit.covariance * along)) / std::abs(response_1);
      const double u_across = std::sqrt(across.dot(fit.covariance * across)) / std::abs(response_1);
      const double device_delay_u =
          channel.device >= 0 ? rig.devices[static_cast<std::size_t>(channel.device)].delay_u_s : 0.0;
      out.u_amplitude = std::hypot(u_along, std::abs(out.Y) * channel.scale_u);
      out.u_phase_rad = std::hypot(u_across / std::abs(out.Y),
                                   w * std::hypot(channel.delay_u_s, device_delay_u, evidence[i].turnaround_u_s));
      const double fundamental = std::abs(out.Y);
      for (int h = 2; h <= H; ++h)
        out.harmonics.push_back(
            std::abs(fit.X[static_cast<std::size_t>(h - 1)] / response(channel, delay, h * w / kTwoPi)) / fundamental);
    }
    dwell.phasors.push_back(std::move(out));
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
  const bool settled = state == State::measuring;
  const int from = settled ? 0 : std::max(0, to - kQuarters * window_periods);
  double w = omega;
  const double u = sum_refined(from, to, with_open, w);
  dwell.t_ref_s = axis_s(totals.t_ref_ns);
  const std::vector<Evidence> evidence = gather_evidence(up_to_now);
  fill_phasors(dwell, w, evidence);
  const double clock = w * rig.excitation.clock_u;
  dwell.frequency_hz = active ? Estimate{w / kTwoPi, std::hypot(u, clock) / kTwoPi} : Estimate{};
  dwell.end_s = axis_s(with_open || to == 0 ? last_sample_ns : std::min(last_sample_ns, blocks.block(to - 1).end_ns));
  for (int c = 0; c < channel_count; ++c) {
    const Live& channel = live[static_cast<std::size_t>(c)];
    if (channel.overrange > 0)
      dwell.warnings.push_back(rig.channels[static_cast<std::size_t>(c)].name + ": " +
                               std::to_string(channel.overrange) + " readings beyond its range were left out");
  }
  if (!settled) {
    if (active) {
      dwell.settles_in_s = verdict.settles_in_s;
      dwell.warnings.push_back("not settled: " + dwell.settling_reason);
    }
    return dwell;
  }
  dwell.settled_s = axis_s(std::max(settled_ns, blocks.count() > 0 ? blocks.block(0).begin_ns : settled_ns));
  dwell.verdict_s = axis_s(verdict_ns);
  dwell.memory_time_s = axis_s(settled_ns) - axis_s(steady_ns);
  dwell.settles_in_s = 0.0;
  const Gain gain = solve_observation(G, observation_weights(rig, evidence, w));
  ElementsResult result = estimate_elements(rig, gain, evidence, {w, u, rig.excitation.clock_u});
  dwell.elements = std::move(result.elements);
  dwell.covariance = std::move(result.covariance);
  for (std::string& warning : result.warnings) dwell.warnings.push_back(std::move(warning));
  return dwell;
}

// ---- the interface --------------------------------------------------------------------------------------------------

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
  p.blocks.sum_channel(channel, from, to, true, p.omega, p.now_ns, p.window);
  const HarmonicFit fit = fit_harmonics(p.window, channel, p.H, 0.0);
  const Channel& about = p.rig.channels[static_cast<std::size_t>(channel)];
  const double delay = about.device >= 0 ? p.rig.devices[static_cast<std::size_t>(about.device)].delay_s : 0.0;
  return fit.usable ? fit.X[0] / response(about, delay, p.omega / kTwoPi) : std::complex<double>{kNaN, kNaN};
}

ChannelNow Pipeline::channel(int channel) const noexcept { return impl_->live[static_cast<std::size_t>(channel)].now; }

}  // namespace dwell
