#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr int kIdleBlocks = 64;  // that are kept while no dwell is on
constexpr double kBeats = 0.5;   // of the drive's frequency: what is farther from it averages out
constexpr double kInPhase_rad = 0.02;
constexpr double kSlip_rad = 0.1;  // of the table's phase against the dwell's, beyond noise: another frequency
constexpr double kStopped = 0.25;  // of the amplitude so far

}  // namespace

void Pipeline::Impl::on_block(std::int64_t end_ns) {
  if (blocks().serials() % kQuarters == 0) live.next_period();
  data.take_block(end_ns);
  const int quarters = kQuarters * window_periods;
  if (blocks().count() < quarters) return;
  const int from = blocks().count() - quarters, to = blocks().count();
  const std::int64_t begin_ns = blocks().block(from).begin_ns;
  const std::int64_t centre_ns = begin_ns + (end_ns - begin_ns) / 2;

  // Before a period has shown the drive's frequency by its phase, the window itself tells it well enough that the
  // first windows do not differ from the later ones for their frequency alone.
  if (tracked() && !std::isfinite(drive.omega())) data.acquire(from, to, centre_ns);
  const HarmonicFit table = data.fit(drive_channel(), from, to, omega(), centre_ns);
  if (!delivers(drive_channel())) return lose_data();
  if (!table.usable) {
    // So few samples a period that one alone cannot be solved: look at two.
    if (window_periods == 1)
      window_periods = 2;
    else
      sparse = table.samples > 0;
    return;
  }
  sparse = false;
  const Complex Y0 = as_observed(rig, drive_channel(), table.X[0], omega(), 1);
  const double per_reading = std::abs(Y0) / std::max(std::abs(table.X[0]), 1e-300);
  // From few degrees of freedom the noise is itself uncertain.
  const double few = 1 + 4 / std::max(1.0, table.samples - (2 * H + 1));
  // While measuring it is known from the dwell; a window may have more.
  const double more_noise = states.measuring() && data.counted() ? std::max(1.0, hold.sigma2 / table.sigma2) : 1.0;
  const double u0 = few * std::sqrt(0.5 * more_noise * table.covariance.trace()) * per_reading;

  // One bad reading makes a window uncertain, but no drive small.
  // Where no phase has told the frequency yet, the window's own, if it is known to a hundredth.
  const double seen_omega = std::isfinite(drive.omega()) || !data.knows_omega() ? drive.omega() : omega();
  seen_drive.take(std::abs(Y0), seen_omega / kTwoPi, !states.at_rest());
  const bool uncertain = std::abs(Y0) < 3 * u0 && (!states.measuring() || std::abs(Y0) < kStopped * drive.amplitude());
  if (std::abs(Y0) < rig.excitation.minimum || uncertain) {
    if (++low_windows >= 2) {
      stop();
    } else if (states.awaits_reason() && finished.waited_enough(blocks().serials())) {
      emit(EndedBy::drive_changed);
    }
    if (states.at_rest()) refresh_reference();
    return;
  }
  low_windows = 0;
  // A drive that has been steady again for two periods has changed; one that is still on its way may stop.
  if (states.awaits_reason() && (blocks().serials() - at.steady_serial >= (2 * window_periods + 1) * kQuarters ||
                                 finished.waited_enough(blocks().serials())))
    emit(EndedBy::drive_changed);
  // Noise alone must not begin a dwell: five standard deviations are passed once in 300 000 windows.
  if (states.at_rest()) {
    if (std::abs(Y0) < 5 * u0) return refresh_reference();
    if (states.interlocked() || !reference.usable(now_ns)) {
      states.bar();
      return refresh_reference();
    }
    states.arm();
    arm(from);
  }
  if (states.settling() && live.holding_changed()) {
    states.settle_anew();
    return begin_hold(blocks().count() - 1);
  }
  if (reference.lost(end_ns)) return end(EndedBy::data_lost, false);
  const bool other = drive.update(to_s(centre_ns - at.steady_ns), Y0 * std::polar(1.0, data.bend(centre_ns)), u0,
                                  data.omega_at(centre_ns, omega())),
             stepped = watch.close();
  if (stepped || (other && !watch.watches()) || slipped(centre_ns, table)) return change(from);
  if (states.settling()) {
    if (tracked() && std::isfinite(drive.omega())) data.take_omega(within_search(rig, drive.omega()));
    if (!reference.pulses_contradict(drive.omega()) && !contradicting_omega()) settle(end_ns);
    states.ask_again(believe_at_ns != INT64_MIN);
  } else if (states.measuring()) {
    refit_measuring(end_ns);
    states.ask_again(believe_at_ns != INT64_MIN);
    // Not from what may be another drive.
    if (!data.counted() || (data.wants_refining() && doubtful_quarters() == 0)) count_anew();
  }
}

void Pipeline::Impl::count_anew() {
  const auto table = data.count_anew(at.steady_ns);
  if (!table) return;
  const HarmonicFit& fit = table->fit;
  const Complex X = fit.X[0];
  hold = {table->t_ref_ns, std::arg(X), omega(), table->u_omega, fit.sigma2};
  drive.refer(std::abs(as_observed(rig, drive_channel(), X, omega(), 1)), omega());
  const double u = std::sqrt(0.5 * fit.covariance.trace()) / std::abs(X);
  if (!fit.usable) return;
  // What the table alone tells of its frequency: the others' motion may hold a little of their transient.
  const bool told = tracked() && fit.information > 0;
  const FrequencyPrior& stated = reference.stated();
  const double information = fit.information + stated.information();
  const double table_omega = told ? omega() + (fit.score + stated.score(omega())) / information : omega();
  const double u_table_omega = told ? 1 / std::sqrt(information) : table->u_omega;
  watch.refer({table->t_ref_ns, fit.mean, fit.X, H, table_omega, data.drift().rate, std::sqrt(fit.sigma2), u, u,
               u_table_omega, quantization_u(drive_channel(), fit, data.sums()) / std::abs(X)});
  const SamplingRegularity& sampling = live[drive_channel()].sampling();
  watch.expect_beats(std::any_of(std::begin(kMainsFundamentals_hz), std::end(kMainsFundamentals_hz), [&](double line) {
    return sampling.distance_hz(line, omega() / kTwoPi) < kBeats * omega() / kTwoPi;
  }));
}

bool Pipeline::Impl::slipped(std::int64_t centre_ns, const HarmonicFit& table) {
  if (!states.measuring() || !data.counted()) return false;
  const double since_s = to_s(centre_ns - hold.t_ref_ns);  // a drift that is known is out of the window's phase
  const double off = std::remainder(std::arg(table.X[0]) - hold.phase_rad - hold.omega * since_s, kTwoPi);
  // A window of few readings may underestimate its noise; the noise of the whole dwell is the lower bound.
  const double more_noise = std::max(1.0, hold.sigma2 / table.sigma2);
  const double u = std::hypot(std::sqrt(0.5 * more_noise * table.covariance.trace()) / std::abs(table.X[0]),
                              hold.u_omega * since_s, hold.omega * watch.late_s());
  slips = std::abs(off) > kSlip_rad + 4 * u ? slips + 1 : 0;
  since_in_phase = std::abs(off) > kInPhase_rad + 4 * u ? since_in_phase + 1 : 0;
  return slips >= 2;
}

void Pipeline::Impl::arm(int from) {
  begin_hold(from);
  at.start_ns = at.armed_ns = at.steady_ns;
  seen_drive.arm();
}

void Pipeline::Impl::begin_hold(int from) {
  at.steady_ns = blocks().block(from).begin_ns;
  at.steady_serial = blocks().block(from).first_serial;
  history_omega = omega();
  data.begin_hold(from);
  time_constant_s = kNaN;
  solve_at_serial = 0;
  verdict = {};
  verdict.settles_in_s = kNaN;
  modal_poles.clear();
  modal_skipped = 0.0;
  extra_poles.clear();
  for (Noise& noise : noises) noise = {};
  modal_refit_at_ns = INT64_MIN;
  modal_fitted = false;
  seen_modes.clear();
  believe_at_ns = INT64_MIN;
  taken_back = {};
  free_ns = at.steady_ns;
  knock_ns = INT64_MIN;
  knocks = false;
  quiet_ns = INT64_MIN;
  settling.restart();
  slips = since_in_phase = 0;
  reference.begin_hold();
  drive.restart();
  watch.restart();
  live.begin_hold();
}

int Pipeline::Impl::doubtful_quarters() const {
  return watch.watches() ? watch.since_good() : std::min(drive.windows_since_good(), 2 * kQuarters);
}

int Pipeline::Impl::blocks_before(int newest_quarters) const {
  int keep = blocks().count();
  while (keep > 0 && blocks().block(keep - 1).first_serial + blocks().block(keep - 1).quarters >
                         blocks().serials() - newest_quarters)
    --keep;
  return keep;
}

void Pipeline::Impl::change(int from) {
  if (states.measuring()) {
    // The dwell ends with the last window that was beyond doubt, and a quarter before it: two periods back at most by
    // the amplitude, as far as the phase has been slipping away by that.
    // A change that begins as a ramp explains most a little after it has begun.
    conclude(blocks_before(std::max(doubtful_quarters() + 2, since_in_phase + 1)), false);
    finished.wait_for_reason(blocks().serials());
    if (tracked()) data.forget_omega();
    states.leave_hold();
    return arm(from);
  }
  states.leave_hold();
  begin_hold(from);
  at.start_ns = at.steady_ns;
}

void Pipeline::Impl::stop() {
  if (states.awaits_reason()) {
    states.forget_dwell();  // what was armed after the change was no dwell
    emit(EndedBy::drive_stopped);
  } else if (!states.at_rest()) {
    conclude(blocks_before(kQuarters * window_periods + doubtful_quarters() + 2), false);
    emit(EndedBy::drive_stopped);
  }
  states.rest();
  data.forget_omega();
}

void Pipeline::Impl::end(EndedBy ended_by, bool with_open) {
  if (states.awaits_reason()) {
    states.forget_dwell();
    // Of a drive that the interlock has cut the motion may tell first.
    emit(ended_by == EndedBy::interlock ? ended_by : EndedBy::drive_changed);
  } else if (!states.at_rest()) {
    // Windows in doubt do not count, whatever ends the dwell; nor does the quarter of a period before the interlock,
    // whose contact may lag what it tells of.
    const int least = ended_by == EndedBy::interlock ? 1 : 0;
    const int doubtful = doubtful_quarters() > 0 ? doubtful_quarters() + 1 : least;
    conclude(blocks_before(doubtful), with_open && doubtful == 0);
    emit(ended_by);
  }
  if (ended_by == EndedBy::data_lost)
    states.lose_sight();
  else
    states.rest();
}

void Pipeline::Impl::lose_data() {
  end(EndedBy::data_lost, false);
  // Another transducer of the table's motion, if it has one, shows the drive from now on.
  live.choose_drive(now_ns, period_s());
}

void Pipeline::Impl::rearm() {
  if (!states.at_rest()) end(EndedBy::rearmed, false);
}

void Pipeline::Impl::refresh_reference() {
  if (blocks().count() < kIdleBlocks) return;
  data.clear();
  for (int c = 0; c < channel_count; ++c) data.set_reference(c, std::isfinite(live[c].value()) ? live[c].value() : 0.0);
}

void Pipeline::Impl::conclude(int to, bool with_open) {
  finished.keep(evaluate(to, with_open, false), at.armed_ns, omega());
}

void Pipeline::Impl::emit(EndedBy ended_by) {
  states.go_on();
  if (finished.conclude(ended_by, now_ns))
    changes |= kCompleted;
  else
    states.forget_dwell();
}

}  // namespace dwell
