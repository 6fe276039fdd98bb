// Which natural oscillations are in the motion: the poles of the modal fit of one hold, from the chain as identified so
// far and from the data themselves (docs/method.md, Settling).
#include <utility>

#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

// Of the hold, its violent beginning: what has decayed by then needs no mode; and more of it each time that the fit
// does not explain the data.
constexpr double kSkipped = 0.15, kSkippedMore = 0.1, kSkippedMost = 0.6;
constexpr double kGone = 1e-6;                      // of an amplitude by then
constexpr double kTrustOmega = 0.005;               // of the drive's frequency likewise
constexpr int kRefinements = 2;                     // steps each time, at most
constexpr double kPenalty = 50.0;                   // of the misfit, for each pole beside the chain's
constexpr double kMostWork = 2e8, kFewestFits = 4;  // multiplications: a tenth of a second; fits of the whole hold
constexpr double kSame = 0.3;                       // rad over the fit, by which two poles must differ
constexpr double kNear = 0.1;                       // relative, of a chain's pole to one that the data show
constexpr double kShorter = 0.3;                    // a step that made things worse is tried again by this part …
constexpr int kShortened = 2;                       // … so many times: to a tenth, beyond which it is another optimum
constexpr double kConverged = 0.1;                  // of the uncertainty of a pole

}  // namespace

double Pipeline::Impl::drive_omega() {
  modal_rate = 0.0;
  if (!tracked()) return omega();
  const int from = blocks().index_of(at.steady_serial + static_cast<std::int64_t>(kUnsure * kQuarters)),
            to = blocks().count();
  double w = omega();
  if (from >= to) return w;
  const std::int64_t middle_ns =
      blocks().block(from).begin_ns + (blocks().block(to - 1).end_ns - blocks().block(from).begin_ns) / 2;
  for (int step = 0; step < 3; ++step) {
    const HarmonicFit fit = data.fit(drive_channel(), from, to, w, middle_ns);
    if (!(fit.information > 0)) return w;
    const double information = fit.information + reference.stated().information();
    const double delta = (fit.score + reference.stated().score(w)) / information;
    w = within_search(rig, w + delta);
    if (std::abs(delta) * std::sqrt(information) < 0.1) break;
  }
  modal_rate = data.seen_drift(from, w, middle_ns);
  return w + modal_rate * to_s(modal_from_ns - middle_ns);
}

// Shows the modal fit the samples that it has not seen.
void Pipeline::Impl::feed_modes() {
  modal_next = std::max(modal_next, history.begin());
  for (; modal_next < history.end(); ++modal_next) {
    const SampleHistory::Sample& s = history[modal_next];
    if (windows.usable(s.channel)) modal.add(s.channel, s.t_ns, s.value);
  }
}

double Pipeline::Impl::fit_modes(double w, std::span<const Complex> poles) {
  --fits_left;
  modal.restart(w, modal_rate, modal_from_ns, poles);
  modal_next = history.first_at(modal_from_ns);
  feed_modes();
  solve_modes();
  return modal.misfit();
}

void Pipeline::Impl::solve_modes() {
  for (int c = 0; c < channel_count; ++c)
    // What is imposed has no transient.
    if (const auto i = static_cast<std::size_t>(c); windows.usable(c))
      modal.solve(c, shows_drive(rig.channels[i]) ? 0.0 : ranges[i], ranges[i]);
}

// The poles of the chain that the steady motion tells of, as far as known; where there are none, nothing.
std::span<const Complex> Pipeline::Impl::chain_poles() {
  for (int c = 0; c < channel_count; ++c)
    if (modal.usable(c))
      usable_observation.observe(c, as_observed(rig, c, modal.phasor(c, 1), modal.omega(), 1));
    else
      usable_observation.leave_out(c);
  if (!usable_observation.solve(state_x)) return {};
  time_constant_s = identified_time_constant(modal.omega());
  return decay.poles();
}

// The poles found beside the chain's, then those of `poles` that have not decayed to nothing where the fit begins.
void Pipeline::Impl::keep_alive(std::span<const Complex> poles, std::vector<Complex>& out) const {
  const double skipped_s = to_s(modal_from_ns - free_ns);
  out.assign(extra_poles.begin(), extra_poles.end());
  const double seen_s = std::max(to_s(now_ns - modal_from_ns), period_s());
  for (Complex pole : poles) {
    pole.real(std::min(pole.real(), -1e-3 * std::abs(pole)));
    if (std::exp(pole.real() * skipped_s) < kGone) continue;
    // Two that the data cannot tell apart are one.
    if (std::none_of(out.begin(), out.end(), [&](Complex other) { return std::abs(pole - other) * seen_s < kSame; }))
      out.push_back(pole);
  }
}

// However long the hold, going over it again has its limit: what was not tried is next time.
int Pipeline::Impl::fits_affordable(std::size_t poles) const {
  const double samples = static_cast<double>(history.end() - history.first_at(modal_from_ns));
  const double products = 0.5 * std::pow(2.0 * H + 3 + 4 * static_cast<double>(poles), 2);
  return static_cast<int>(std::clamp(kMostWork / std::max(1.0, samples * products), kFewestFits, 1000.0));
}

bool Pipeline::Impl::refit_modes() {
  if (modal_poles.empty() && decay.poles().empty()) return false;
  const std::int64_t oldest_ns = history[history.begin()].t_ns, held_ns = now_ns - free_ns;
  // The first period may hold the end of what was before.
  const std::int64_t skipped_ns =
      std::max(to_ns(kUnsure * period_s()), static_cast<std::int64_t>(modal_skipped * static_cast<double>(held_ns)));
  modal_from_ns = std::max(free_ns + skipped_ns, oldest_ns);
  for (double& range : ranges) range = 0.0;
  for (auto i = history.first_at(modal_from_ns); i < history.end(); ++i) {
    const SampleHistory::Sample& s = history[i];
    const auto c = static_cast<std::size_t>(s.channel);
    ranges[c] = std::max(ranges[c], std::abs(s.value - blocks().reference(s.channel)));
  }
  // At first by the table alone, then by all channels.
  const bool fitted = modal.usable(drive_channel()) && modal.t0_ns() >= at.steady_ns;
  const double w = drive_omega();
  const bool drifts = modal_rate != 0 || modal.rate() != 0;
  const double first_w = fitted && from_motion() && !drifts ? modal.omega() : w;
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
  fits_left = fits_affordable(modal_poles.size() + kExtraPoles);
  for (int candidate = 0; candidate < 4 && (candidate == 0 || fits_left > 0); ++candidate) {
    extra_poles.clear();
    if (candidate < 2) extra_poles = kept_extras;
    if (candidate == 3) {
      const std::int64_t from_ns = std::exchange(modal_from_ns, std::max(modal_from_ns, now_ns - held_ns / 3));
      fit_modes(w + modal_rate * to_s(modal_from_ns - from_ns), {});
      modal_from_ns = from_ns;
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
      kept_w = modal.omega();
      spare_poles = extra_poles;
      if (explained()) break;
    }
    // From before a knock no poles explain what comes after.
    if (candidate == 0 && (knocks || modal_skipped >= kSkippedMost) && !explained()) {
      const std::int64_t first_ns = knock_ns > modal_from_ns ? knock_ns : modal_from_ns + (now_ns - modal_from_ns) / 2;
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
  if (best_poles != kept_poles || modal.omega() != kept_w) {
    fit_modes(kept_w, kept_poles);
    compare_halves();
  }
  best_poles = kept_poles;
  extra_poles = spare_poles;
  if (!knocks && fits_left > 0 && find_extra_pole()) {
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
  if (modal.poles().size() < extras + modal_poles.size()) return;
  const auto chain = chain_poles();
  trial_poles.clear();
  for (std::size_t m = 0; m < modal_poles.size(); ++m)
    if (modal.shows(extras + m)) trial_poles.push_back(modal_poles[m]);
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
  std::swap(modal, spare);
  for (int c = 0; c < channel_count; ++c) modal.expect(c, spare.variance(c));
  const double misfit = fit_modes(w, trial_poles);
  if (misfit < best || !std::isfinite(best)) {
    best_poles = trial_poles;
    return misfit;
  }
  std::swap(modal, spare);
  return best;
}

double Pipeline::Impl::refine_poles(double misfit, int steps) {
  double best = misfit;
  for (int i = 0; i < steps && fits_left > 0; ++i) {
    const auto moved = modal.refined(kTrust, from_motion() ? kTrustOmega : 0.0);
    if (modal.converged() < kConverged) break;
    const double w = modal.omega(), by = (from_motion() ? within_search(rig, modal.refined_omega()) : w) - w;
    trial_poles.assign(moved.begin(), moved.end());
    double better = try_poles(w + by, best);
    // A drive beside a pole is far from linear in both: a step that goes too far is shortened.
    double part = kShorter;
    for (int shorter = 0; shorter < kShortened && !(better < best) && fits_left > 0; ++shorter, part *= kShorter) {
      const auto poles = modal.poles(), whole = modal.moved_poles();
      for (std::size_t m = 0; m < poles.size(); ++m) trial_poles[m] = poles[m] + part * (whole[m] - poles[m]);
      better = try_poles(w + part * by, best);
    }
    if (!(better < best)) break;
    best = better;
  }
  compare_halves();
  return best;
}

// best_poles are those beside the chain, then the chain's.
void Pipeline::Impl::take_best_poles() {
  for (std::size_t i = 0; i < extra_poles.size(); ++i) extra_poles[i] = best_poles[i];
  modal_poles.assign(best_poles.begin() + static_cast<std::ptrdiff_t>(extra_poles.size()), best_poles.end());
}

void Pipeline::Impl::remember_modes() {
  for (int c = 0; c < channel_count; ++c)
    left_over[static_cast<std::size_t>(c)] = modal.usable(c) ? std::max(0.0, unexplained(c)) : 0.0;
  static_cast<void>(modal.refined(kTrust, from_motion() ? kTrustOmega : 0.0));
  modal.propagate_poles(!from_motion());
  seen_modes.take(modal, now_ns, left_over);
  if (!explained() || history[history.begin()].t_ns > modal.t0_ns()) return;
  const WholeHold::Given given{
      history, modal,      chain_poles(), live.imposed(), std::max(free_ns, history[history.begin()].t_ns),
      now_ns,  period_s(), !from_motion()};
  std::fill(left_over.begin(), left_over.end(), 0.0);
  // A fit that explains more of the hold takes the place of all before: a mode that only these show was none.
  for (whole_hold.begin(given); whole_hold.earlier(given);) {
    seen_modes.clear();
    seen_modes.take(whole_hold.modes(), now_ns, left_over);
  }
}

double Pipeline::Impl::slowest_rate() const {
  double slowest = INFINITY;
  for (const Complex& pole : modal.poles())
    if (pole.real() < 0) slowest = std::min(slowest, -pole.real());
  return slowest;
}

}  // namespace dwell
