// Which natural oscillations are in the motion: the poles of the modal fit of one hold, from the chain as identified so
// far and from the data themselves (docs/method.md, Settling).
#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
HoldNow Pipeline::Impl::hold_now() const {
  for (std::size_t i = 0; i < live.size(); ++i) {
    const ChannelIntake& intake = live[i].intake;
    fitted_channels[i] = {readings[i].usable,
                          shows_drive(rig.channels[i]),
                          blocks.reference(static_cast<int>(i)),
                          intake.refresh_half_s(),
                          intake.step(),
                          live[i].sampling};
  }
  return {now_ns, steady_ns, omega, !from_motion(), drive_channel, fitted_channels};
}

SeenFrequency Pipeline::Impl::drive_omega() const {
  if (!tracked()) return {omega};
  const int from = blocks.index_of(steady_serial + static_cast<std::int64_t>(kUnsure * kQuarters)), to = blocks.count();
  double w = omega;
  if (from >= to) return {w};
  const std::int64_t middle_ns =
      blocks.block(from).begin_ns + (blocks.block(to - 1).end_ns - blocks.block(from).begin_ns) / 2;
  for (int step = 0; step < 3; ++step) {
    blocks.sum_channel(drive_channel, from, to, w, middle_ns, window);
    const HarmonicFit fit = fit_harmonics(window, drive_channel, H, blocks.reference(drive_channel));
    if (!(fit.information > 0)) return {w};
    const double information = fit.information + stated.information();
    const double delta = (fit.score + stated.score(w)) / information;
    w = within_search(rig, w + delta);
    if (std::abs(delta) * std::sqrt(information) < 0.1) break;
  }
  return {w, seen_drift(from, w, middle_ns), middle_ns};
}

void Pipeline::Impl::remember_modes() {
  const HoldNow now = hold_now();
  for (int c = 0; c < channel_count; ++c)
    left_over[static_cast<std::size_t>(c)] =
        hold_fit.fit().usable(c) ? std::max(0.0, residual_noise.unexplained(c, hold_fit.fit(), now)) : 0.0;
  static_cast<void>(hold_fit.fit().refined(PoleSearch::kTrust, from_motion() ? PoleSearch::kTrustOmega : 0.0));
  hold_fit.fit().propagate_poles(!from_motion());
  seen_modes.take(hold_fit.fit(), now_ns, left_over);
  if (!explained() || history[history.begin()].t_ns > hold_fit.fit().t0_ns()) return;
  const WholeHold::Given given{history,
                               hold_fit.fit(),
                               provisional_chain.seen_by(hold_fit.fit()),
                               is_imposed,
                               std::max(knock_watch.free_since_ns(), history[history.begin()].t_ns),
                               now_ns,
                               period_s(),
                               !from_motion()};
  std::fill(left_over.begin(), left_over.end(), 0.0);
  // A fit that explains more of the hold takes the place of all before: a mode that only these show was none.
  for (whole_hold.begin(given); whole_hold.earlier(given);) {
    seen_modes.clear();
    seen_modes.take(whole_hold.modes(), now_ns, left_over);
  }
}

}  // namespace dwell
