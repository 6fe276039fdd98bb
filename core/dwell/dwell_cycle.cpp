#include "core/dwell/pipeline_impl.hpp"

namespace dwell {

void Pipeline::Impl::on_block(std::int64_t end_ns) {
  if (blocks().serials() % kQuarters == 0) live.next_period();
  data.take_block(end_ns);
  const bool unknown = inexact() && (states.at_rest() || !std::isfinite(tracker.omega()));
  const double near = unknown ? search_drive(end_ns) : omega();
  const int quarters = kQuarters * windows.length().periods();
  if (blocks().count() < quarters) return;
  const int from = blocks().count() - quarters, to = blocks().count();
  const std::int64_t begin_ns = blocks().block(from).begin_ns;
  const std::int64_t centre_ns = begin_ns + (end_ns - begin_ns) / 2;

  // At first the phase has not shown the drive's frequency. Then the window itself gives it, well enough that the first
  // windows agree with later ones.
  if (unknown) data.acquire(from, to, centre_ns, near);
  const HarmonicFit fit = data.fit(drive_channel(), from, to, omega(), centre_ns);
  // At rest a channel without noise reads one and the same value, too.
  if (!delivers(drive_channel()) || (!states.at_rest() && live[drive_channel()].stuck(period_s()))) return lose_data();
  if (!fit.usable) return windows.length().not_fitted(fit.samples > 0);
  windows.length().fitted();
  const DriveTracker::Window table{centre_ns, fit, as_observed(rig, drive_channel(), fit.X[0], omega(), 1),
                                   moves_elsewhere(fit)};
  if (!look_at_drive(table, from)) return;
  if (states.settling() && live.holding_changed()) {
    states.settle_anew();
    return begin_hold(blocks().count() - 1);
  }
  if (reference.lost(end_ns)) return end(EndedBy::data_lost, false);
  const double since_s = to_s(centre_ns - at.steady_ns), w = data.omega_at(centre_ns, omega());
  if (tracker.changed(table, since_s, data.bend(centre_ns), w, during())) return change(from);
  if (states.settling()) {
    if (inexact() && std::isfinite(tracker.omega())) data.take_omega(within_search(rig, tracker.omega()));
    if (!reference.pulses_contradict(tracker.omega()) && !contradicting_omega()) settle(end_ns);
    states.set_unconfirmed(modes.unconfirmed());
  } else if (states.measuring()) {
    refit_measuring(end_ns);
    states.set_unconfirmed(modes.unconfirmed());
    // While the newest quarters may hold another drive, ω is not refined from them.
    if (!data.sums_valid() || (data.wants_refining() && doubtful_quarters() == 0)) resum();
    if (doubtful_quarters() == 0 && errors_in_motion.due(end_ns, period_s()))
      look_for_moving_errors(blocks().count(), false);
  }
}

double Pipeline::Impl::search_drive(std::int64_t end_ns) {
  const double nominal = data.nominal_omega();
  if (!search.wanted()) return nominal;
  const std::int64_t since_ns = std::max(states.at_rest() ? blocks().block(0).begin_ns : at.armed_ns,
                                         end_ns - to_ns(search.longest_s() * windows.length().periods()));
  const double taken_at = blocks().block(blocks().count() - 1).omega;
  const auto found = search.find(history, drive_channel(), since_ns, end_ns);
  if (!found) return search.near(taken_at, nominal) ? nominal : taken_at;
  const double omega = search.near(*found, nominal) ? nominal : *found;
  if (search.near(omega, taken_at)) return omega;
  data.take_omega(omega);
  rebuild_blocks(since_ns, end_ns);
  if (states.at_rest()) return omega;
  begin_hold(std::max(0, blocks().count() - kQuarters * windows.length().periods()));
  at.start_ns = at.steady_ns;
  return omega;
}

double Pipeline::Impl::moves_elsewhere(const HarmonicFit& fit) const {
  double largest = 0.0;
  for (int h = 2; h <= harmonics() && h * omega() <= kTwoPi * rig.excitation.search_high_hz; ++h) {
    const Complex X = fit.X[static_cast<std::size_t>(h - 1)];
    largest = std::max(largest, std::abs(as_observed(rig, drive_channel(), X, omega(), h)));
  }
  return largest;
}

DriveTracker::During Pipeline::Impl::during() const {
  return {!states.at_rest(), states.measuring(), states.measuring() && data.sums_valid()};
}

bool Pipeline::Impl::look_at_drive(const DriveTracker::Window& table, int from) {
  const DriveTracker::Sight sight = tracker.see(table, data.knows_omega() ? omega() : kNaN, during());
  const bool waited_enough = states.awaits_reason() && finished.waited_enough(blocks().serials());
  if (sight == DriveTracker::Sight::rests || sight == DriveTracker::Sight::low) {
    if (sight == DriveTracker::Sight::rests)
      stop();
    else if (waited_enough)
      emit(EndedBy::drive_changed);
    if (states.at_rest()) refresh_reference();
    return false;
  }
  // A drive that has been steady again for two periods has changed; any other may still stop.
  if (waited_enough || (states.awaits_reason() &&
                        blocks().serials() - at.steady_serial >= (2 * windows.length().periods() + 1) * kQuarters))
    emit(EndedBy::drive_changed);
  // Without a known frequency there is nothing to judge.
  if (!states.at_rest()) return sight != DriveTracker::Sight::elsewhere || std::isfinite(tracker.omega());
  if (sight == DriveTracker::Sight::moves && !states.interlocked() && reference.usable(now_ns)) {
    states.arm();
    arm(from);
    return true;
  }
  if (sight == DriveTracker::Sight::moves) states.bar();
  refresh_reference();
  return false;
}

void Pipeline::Impl::resum() {
  const auto table = data.resum(at.steady_ns);
  if (!table) return;
  const int c = drive_channel();
  const double amplitude = std::abs(as_observed(rig, c, table->fit.X[0], omega(), 1));
  tracker.refer({table->t_ref_ns, table->fit, amplitude, omega(), table->u_omega, data.drift().rate,
                 quantization_u(c, table->fit, data.sums())},
                live[c].sampling());
}

void Pipeline::Impl::arm(int from) {
  begin_hold(from);
  at.start_ns = at.armed_ns = at.steady_ns;
  tracker.arm();
}

void Pipeline::Impl::begin_hold(int from) {
  at.steady_ns = blocks().block(from).begin_ns;
  at.steady_serial = blocks().block(from).first_serial;
  windows.begin_hold();
  data.begin_hold(from);
  provisional_chain.forget_time_constant();
  verdict = {};
  verdict.settles_in_s = kNaN;
  modes.begin_hold(at.steady_ns);
  reference.begin_hold();
  tracker.begin_hold();
  live.begin_hold();
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
    conclude(blocks_before(tracker.quarters_of_change()), false);
    finished.wait_for_reason(blocks().serials());
    if (inexact()) data.forget_omega();
    states.leave_hold();
    return arm(from);
  }
  states.leave_hold();
  begin_hold(from);
  at.start_ns = at.steady_ns;
}

void Pipeline::Impl::stop() {
  if (states.awaits_reason()) {
    states.forget_dwell();  // the one armed after the change was no dwell
    emit(EndedBy::drive_stopped);
  } else if (!states.at_rest()) {
    conclude(blocks_before(kQuarters * windows.length().periods() + doubtful_quarters() + 2), false);
    emit(EndedBy::drive_stopped);
  }
  states.rest();
  data.forget_omega();
}

void Pipeline::Impl::end(EndedBy ended_by, bool with_open) {
  if (states.awaits_reason()) {
    states.forget_dwell();
    // If the interlock has cut the drive, the motion may show it before the interlock's edge.
    emit(ended_by == EndedBy::interlock ? ended_by : EndedBy::drive_changed);
  } else if (!states.at_rest()) {
    // Doubtful windows never count. Before an interlock's edge a quarter period does not count either: the contact may
    // lag the cut of the drive.
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
  at.lost_ns = now_ns;
  // The drive may be seen by another transducer of the table's motion.
  live.choose_drive(now_ns, period_s());
}

// What was read before belongs to the specimen as it was, and to the dwell that has ended.
void Pipeline::Impl::rearm() {
  if (states.at_rest()) return;
  end(EndedBy::rearmed, false);
  data.close();
  data.clear();
  data.open(now_ns);
}

void Pipeline::Impl::refresh_reference() {
  if (blocks().count() < Blocks::kFine) return;
  data.clear();
  for (int c = 0; c < live.count(); ++c) data.set_reference(c, std::isfinite(live[c].value()) ? live[c].value() : 0.0);
}

ErrorsInMotion::About Pipeline::Impl::about_moving(int c, HarmonicFit fit, std::int64_t t_ref_ns,
                                                   std::int64_t about_ns) const {
  const SamplingRegularity& sampling = live[c].sampling();
  const double phase = omega() * to_s(about_ns - t_ref_ns) + data.bend(about_ns), step = live[c].intake().step();
  for (int h = 1; h <= harmonics(); ++h) fit.X[static_cast<std::size_t>(h - 1)] *= std::polar(1.0, h * phase);
  // Squared, hum has twice its frequency. If that reads as twice the drive's, it looks like an error that grows with
  // the motion.
  for (const double line : kMainsFundamentals_hz)
    fit.usable = fit.usable && sampling.distance_hz(2 * line, omega() / std::numbers::pi) >
                                   2 * kMainsWander_hz + 1 / to_s(now_ns - at.settled_ns);
  return {{.fit = fit,
           .t_ref_ns = about_ns,
           .omega = data.omega_at(about_ns, omega()),
           .interval_s = every(c) * sampling.interval_s(),
           .rounding = std::isfinite(step) ? step : 0.0},
          std::hypot(live[c].turnaround_u_s(), live[c].intake().refresh_half_s() / std::numbers::sqrt3)};
}

void Pipeline::Impl::look_for_moving_errors(int to, bool at_once) {
  struct Ask {
    Impl& of;
    int to;
    bool by_sums;
    HarmonicFits fits;
    [[nodiscard]] int every(int c) const { return of.every(c); }
    [[nodiscard]] double transient(int c, std::int64_t t_ns) const { return of.modes.transient(c, t_ns); }
    [[nodiscard]] ErrorsInMotion::About about(int c, std::int64_t about_ns) {
      if (by_sums)
        return of.about_moving(c, fits.fit(c, of.blocks().reference(c)), of.data.sums().t_ref_ns(), about_ns);
      return of.about_moving(c, of.data.fit(c, 0, to, of.omega(), about_ns), about_ns, about_ns);
    }
  };
  Ask ask{*this, to, data.sums_valid() && to == blocks().count(), {data.sums(), harmonics()}};
  const std::int64_t from_ns = blocks().block(0).begin_ns, end_ns = blocks().block(to - 1).end_ns;
  if (at_once)
    errors_in_motion.look(history, from_ns, end_ns, ask);
  else
    errors_in_motion.go_on(history, from_ns, end_ns, ask);
}

void Pipeline::Impl::conclude(int to, bool with_open) {
  if (states.measuring() && to > 0) look_for_moving_errors(to, true);
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
