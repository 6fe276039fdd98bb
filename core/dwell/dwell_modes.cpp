// Which natural oscillations are in the motion: the poles of the modal fit of one hold, from the chain as identified so
// far and from the data themselves (docs/method.md, Settling).
#include <utility>

#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

// Of the hold, its violent beginning: what has decayed by then needs no mode; and more of it each time that the fit
// does not explain the data.
constexpr double kSkipped = 0.15, kSkippedMore = 0.1, kSkippedMost = 0.6;
constexpr double kGone = 1e-6;         // of an amplitude by then
constexpr double kTrustOmega = 0.005;  // of the drive's frequency likewise
constexpr int kRefinements = 2;        // steps each time, at most
constexpr double kPenalty = 50.0;      // of the misfit, for each pole beside the chain's
constexpr double kSame = 0.3;          // rad over the fit, by which two poles must differ
constexpr double kNear = 0.1;          // relative, of a chain's pole to one that the data show
constexpr double kShorter = 0.3;       // a step that made things worse is tried again by this part …
constexpr int kShortened = 2;          // … so many times: to a tenth, beyond which it is another optimum
constexpr double kConverged = 0.1;     // of the uncertainty of a pole

}  // namespace

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

// The poles of the chain that the steady motion tells of, as far as known; where there are none, nothing.
std::span<const Complex> Pipeline::Impl::chain_poles() {
  for (int c = 0; c < channel_count; ++c)
    if (hold_fit.fit().usable(c))
      usable_observation.observe(c, as_observed(rig, c, hold_fit.fit().phasor(c, 1), hold_fit.fit().omega(), 1));
    else
      usable_observation.leave_out(c);
  if (!usable_observation.solve(state_x)) return {};
  time_constant_s = identified_time_constant(hold_fit.fit().omega());
  return decay.poles();
}

// The poles found beside the chain's, then those of `poles` that have not decayed to nothing where the fit begins.
void Pipeline::Impl::keep_alive(std::span<const Complex> poles, std::vector<Complex>& out) const {
  const double skipped_s = to_s(hold_fit.from_ns() - knock_watch.free_since_ns());
  out.assign(extra_poles.begin(), extra_poles.end());
  const double seen_s = std::max(to_s(now_ns - hold_fit.from_ns()), period_s());
  for (Complex pole : poles) {
    pole.real(std::min(pole.real(), -1e-3 * std::abs(pole)));
    if (std::exp(pole.real() * skipped_s) < kGone) continue;
    // Two that the data cannot tell apart are one.
    if (std::none_of(out.begin(), out.end(), [&](Complex other) { return std::abs(pole - other) * seen_s < kSame; }))
      out.push_back(pole);
  }
}

bool Pipeline::Impl::refit_modes() {
  if (modal_poles.empty() && decay.poles().empty()) return false;
  const std::int64_t oldest_ns = history[history.begin()].t_ns, free_ns = knock_watch.free_since_ns(),
                     held_ns = now_ns - free_ns;
  // The first period may hold the end of what was before.
  const std::int64_t skipped_ns =
      std::max(to_ns(kUnsure * period_s()), static_cast<std::int64_t>(modal_skipped * static_cast<double>(held_ns)));
  hold_fit.begin_at(std::max(free_ns + skipped_ns, oldest_ns));
  hold_fit.measure_ranges(hold_now().channels);
  // At first by the table alone, then by all channels.
  const bool fitted = hold_fit.fit().usable(drive_channel) && hold_fit.fit().t0_ns() >= steady_ns;
  const SeenFrequency seen = drive_omega();
  const double w = seen.at(hold_fit.from_ns());
  hold_fit.set_rate(seen.rate);
  const bool drifts = seen.rate != 0 || hold_fit.fit().rate() != 0;
  const double first_w = fitted && from_motion() && !drifts ? hold_fit.fit().omega() : w;
  if (modal_poles.empty()) {
    // From the windows' mean, the first time.
    modal_poles.assign(decay.poles().begin(), decay.poles().end());
  }
  // Where poles may come from, until some explain the data: those so far, of which the ones that show nowhere are the
  // chain's as now identified; that chain; the same without what was found beside it; the chain that the latest third
  // tells of, without any modes.
  double best = INFINITY;
  kept_extras = extra_poles;
  kept_poles.clear();
  hold_fit.allow(hold_fit.affordable(modal_poles.size() + kExtraPoles));
  for (int candidate = 0; candidate < 4 && (candidate == 0 || hold_fit.may_fit()); ++candidate) {
    extra_poles.clear();
    if (candidate < 2) extra_poles = kept_extras;
    if (candidate == 3) {
      const std::int64_t from_ns = hold_fit.from_ns();
      hold_fit.begin_at(std::max(from_ns, now_ns - held_ns / 3));
      fit_modes(w + seen.rate * to_s(hold_fit.from_ns() - from_ns), {});
      hold_fit.begin_at(from_ns);
    }
    if (candidate == 0 && fitted) renew_silent_poles();
    const std::span<const Complex> poles = candidate == 0 ? std::span<const Complex>(modal_poles) : chain_poles();
    if (poles.empty()) continue;
    keep_alive(poles, best_poles);
    const double misfit = refine_poles(fit_modes(candidate == 0 ? first_w : w, best_poles),
                                       candidate == 0 ? kRefinements : kManyRefinements);
    const double penalized = misfit + kPenalty * static_cast<double>(extra_poles.size());
    if (penalized < best) {
      best = penalized;
      kept_poles = best_poles;
      kept_w = hold_fit.fit().omega();
      spare_poles = extra_poles;
      if (explained()) break;
    }
    // From before a knock no poles explain what comes after.
    if (candidate == 0 && (knock_watch.any() || modal_skipped >= kSkippedMost) && !explained()) {
      const std::int64_t from_ns = hold_fit.from_ns();
      const std::int64_t first_ns =
          knock_watch.alarmed_since(from_ns) ? *knock_watch.alarm_ns() : from_ns + (now_ns - from_ns) / 2;
      bool explains = fit_since_knock(w, first_ns);
      if (!explains && !extra_poles.empty()) {
        // A knock within the fit looks like lines beside the chain.
        std::erase_if(extra_poles, [](Complex pole) { return pole.real() < 0; });
        explains = fit_since_knock(w, first_ns);
        if (!explains) extra_poles = kept_extras;
      }
      if (explains) {
        take_best_poles();
        modal_skipped = 0.0;
        return true;
      }
    }
  }
  if (!(best < INFINITY)) return false;
  if (best_poles != kept_poles || hold_fit.fit().omega() != kept_w) {
    fit_modes(kept_w, kept_poles);
    residual_noise.compare_halves(hold_fit, now_ns);
  }
  best_poles = kept_poles;
  extra_poles = spare_poles;
  if (!knock_watch.any() && hold_fit.may_fit() && find_extra_pole()) {
    std::rotate(extra_poles.begin(), extra_poles.end() - 1, extra_poles.end());
    best_poles.insert(best_poles.begin(), extra_poles.front());
    refine_poles(fit_modes(kept_w, best_poles), kManyRefinements);
  }
  take_best_poles();
  judge_extra_poles();
  // What cannot be explained is shed: the next fit begins later, where less of it is left.
  modal_skipped = explained() ? kSkipped : std::min(modal_skipped + kSkippedMore, kSkippedMost);
  return true;
}

// A pole that shows in no channel is known from the chain alone: from what is known of it now.
void Pipeline::Impl::renew_silent_poles() {
  const auto extras = extra_poles.size();
  if (hold_fit.fit().poles().size() < extras + modal_poles.size()) return;
  const auto chain = chain_poles();
  trial_poles.clear();
  for (std::size_t m = 0; m < modal_poles.size(); ++m)
    if (hold_fit.fit().shows(extras + m)) trial_poles.push_back(modal_poles[m]);
  for (const Complex& pole : chain) {
    if (trial_poles.size() == modal_poles.size()) break;
    if (std::none_of(trial_poles.begin(), trial_poles.end(),
                     [&](Complex other) { return std::abs(pole - other) < kNear * std::abs(pole); }))
      trial_poles.push_back(pole);
  }
  if (!chain.empty()) modal_poles = trial_poles;
}

// Takes trial_poles and w if they explain the data better; the fit is that of best_poles afterwards.
double Pipeline::Impl::try_poles(double w, double best) {
  if (hold_fit.attempt(w, trial_poles, hold_now().channels, best)) best_poles = trial_poles;
  return best;
}

double Pipeline::Impl::refine_poles(double misfit, int steps) {
  double best = misfit;
  for (int i = 0; i < steps && hold_fit.may_fit(); ++i) {
    const auto moved = hold_fit.fit().refined(kTrust, from_motion() ? kTrustOmega : 0.0);
    if (hold_fit.fit().converged() < kConverged) break;
    const double w = hold_fit.fit().omega(),
                 by = (from_motion() ? within_search(rig, hold_fit.fit().refined_omega()) : w) - w;
    trial_poles.assign(moved.begin(), moved.end());
    double better = try_poles(w + by, best);
    // A drive beside a pole is far from linear in both: a step that goes too far is shortened.
    double part = kShorter;
    for (int shorter = 0; shorter < kShortened && !(better < best) && hold_fit.may_fit(); ++shorter, part *= kShorter) {
      const auto poles = hold_fit.fit().poles(), whole = hold_fit.fit().moved_poles();
      for (std::size_t m = 0; m < poles.size(); ++m) trial_poles[m] = poles[m] + part * (whole[m] - poles[m]);
      better = try_poles(w + part * by, best);
    }
    if (!(better < best)) break;
    best = better;
  }
  residual_noise.compare_halves(hold_fit, now_ns);
  return best;
}

// best_poles are those beside the chain, then the chain's.
void Pipeline::Impl::take_best_poles() {
  for (std::size_t i = 0; i < extra_poles.size(); ++i) extra_poles[i] = best_poles[i];
  modal_poles.assign(best_poles.begin() + static_cast<std::ptrdiff_t>(extra_poles.size()), best_poles.end());
}

void Pipeline::Impl::remember_modes() {
  const HoldNow now = hold_now();
  for (int c = 0; c < channel_count; ++c)
    left_over[static_cast<std::size_t>(c)] =
        hold_fit.fit().usable(c) ? std::max(0.0, residual_noise.unexplained(c, hold_fit.fit(), now)) : 0.0;
  static_cast<void>(hold_fit.fit().refined(kTrust, from_motion() ? kTrustOmega : 0.0));
  hold_fit.fit().propagate_poles(!from_motion());
  seen_modes.take(hold_fit.fit(), now_ns, left_over);
  if (!explained() || history[history.begin()].t_ns > hold_fit.fit().t0_ns()) return;
  const WholeHold::Given given{history,
                               hold_fit.fit(),
                               chain_poles(),
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
