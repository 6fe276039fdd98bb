// How much of the transient is left, when that is little enough, and its being taken out of the data that count.
#include <utility>

#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr double kHoldGrowth = 1.25;              // of the hold, before its poles are refined again
constexpr double kGrowthFar = 2.0, kAhead = 0.5;  // … at most, and part of the time expected to be left
constexpr double kGrowthMeasuring = 2.0;          // the same after the verdict
constexpr double kStale = 0.05;                   // … from which a verdict wants them refined first
constexpr int kFitsMeasuring = 12;                // of the whole hold, at each refit after the verdict
constexpr double kSeenThrough = 3.0;              // decay times, after which no mode can still hide
constexpr double kMatters = 0.05;                 // of the variance
constexpr double kOwnOmega = 2.5;                 // standard deviations
constexpr double kTurned = 0.1;                   // standard deviations
constexpr int kRefits = 4;                        // of the fit at a better frequency, at most
// Of what is allowed, which is itself an estimate. No derivation; set on the study. White noise: at 0.8, 0.85, 0.9 the
// median lateness is 0.50, 0.38, 0.27, and at the latter two none of 600 verdicts comes too early. No uncertainty holds
// what rounding does to the fit: of channels rounded more coarsely than their noise 11 of 2000 come too early at 0.85
// and at 0.82, 8 at 0.80.
constexpr double kSafety = 0.85, kSafetyRounded = 0.80;
constexpr double kSure = 3.0;                         // standard deviations of what may be left of the transient
constexpr double kMostTakenOut = 8.0;                 // of what may be left, where data begin to count
constexpr double kNegligible = 1e-3;                  // of the tolerance: nothing is subtracted any more …
constexpr double kNegligibleOfNoise = 0.2;            // … or of the uncertainty of the phasor
constexpr double kPerParameter = 4.0;                 // readings
constexpr double kSudden = 1.2;                       // times what is allowed, a moment ago
constexpr double kAgain = 0.05, kAgainPeriods = 2.0;  // of the hold, periods: later, that is asked again
constexpr double kShortest = 2.0;                     // and kUnsure, periods, before anything is said

}  // namespace

// What may be left of the transient in a channel: the tolerance of its amplitude, or what ten periods' noise hides.
double Pipeline::Impl::allowed_left(int c) const {
  const double span_s = std::max(1e-9, to_s(now_ns - modal.t0_ns()));
  const double in_ten = std::max(1.0, modal.samples(c) / span_s * 10 * period_s());
  const Noise& noise = noises[static_cast<std::size_t>(c)];
  const double floor = std::min({modal.variance(c), noise.variance, noise.in_later > 0 ? noise.later : INFINITY});
  return std::max({rig.tolerance * std::abs(modal.phasor(c, 1)), 3 * std::sqrt(floor * 2 / in_ten), 1e-300});
}

// How much of the transient may be left at t, of what is allowed: the worst of all channels.
double Pipeline::Impl::modal_left(std::int64_t t_ns, int* worst) const {
  double largest = 0.0;
  for (int c = 0; c < channel_count; ++c) {
    if (!windows.usable(c)) continue;
    if (!modal.usable(c)) return INFINITY;
    if (shows_drive(rig.channels[static_cast<std::size_t>(c)])) continue;
    const double allowed = allowed_left(c);
    const ModalFit::Left left = modal.left(c, t_ns);
    double ratio = (left.envelope + kSure * left.u) / ((rounded(c) ? kSafetyRounded : kSafety) * allowed);
    // What the fit leaves over beyond the noise is not known to be no transient.
    if (const double power = unexplained(c); power > 0) ratio = std::max(ratio, std::sqrt(2 * power) / allowed);
    if (ratio > largest) {
      largest = ratio;
      if (worst) *worst = c;
    }
  }
  return largest;
}

// What may be left without being taken out.
double Pipeline::Impl::negligible_left(int c) const {
  return std::max(kNegligible * rig.tolerance * std::abs(modal.phasor(c, 1)),
                  kNegligibleOfNoise * std::sqrt(modal.variance(c) * 2 / modal.samples(c)));
}

// What has become negligible in every channel is evaluated no more.
void Pipeline::Impl::fade_modes(std::int64_t t_ns) {
  for (std::size_t m = 0; m < modal.poles().size(); ++m) {
    if (modal.poles()[m].real() == 0) continue;
    double fades_s = 0.0;
    for (int c = 0; c < channel_count; ++c)
      if (modal.usable(c)) {
        const double most = modal.most(c, m, t_ns) / negligible_left(c);
        if (most > 1) fades_s = std::max(fades_s, std::log(most) / -modal.poles()[m].real());
      }
    modal.fade(m, t_ns + to_ns(std::min(fades_s, rig.memory_s)));
  }
}

bool Pipeline::Impl::settle_by_modes(std::int64_t end_ns) {
  if (rig.mass_count() == 0) return false;
  // Windows alone would be believed too soon.
  if (to_s(end_ns - free_ns) < (kUnsure + kShortest) * 0.99 * period_s()) return true;
  bool fresh = now_ns >= modal_refit_at_ns;
  if (!fresh && modal_fitted) {
    feed_modes();
    solve_modes();
    modal.propagate_poles(!from_motion());
    // The last refit had fewer data than their uncertainty now counts. Before a verdict the poles are refined on all.
    const auto grown_ns = static_cast<std::int64_t>(kStale * static_cast<double>(refitted_ns - free_ns));
    const bool knocked = knock_ns == INT64_MIN && explained() && knocked_now(end_ns - to_ns(period_s() / kQuarters));
    if (knocked) heed_knock(end_ns);
    fresh = !(knock_ns > refitted_ns) && now_ns > refitted_ns + grown_ns && modal_left(end_ns, nullptr) <= 1;
  }
  if (fresh) {
    modal_fitted = refit_modes();
    if (!modal_fitted) {
      if (!decay.poles().empty()) refit_later(kHoldGrowth);
      return false;
    }
    refitted_ns = now_ns;
    if (explained()) knock_ns = INT64_MIN;
    modal.propagate_poles(!from_motion());
    // Far from settled there is time.
    const double left = modal_left(end_ns, nullptr);
    const double ahead_s =
        left > 1 && std::isfinite(left) && explained() ? kAhead * std::log(left) / slowest_rate() : 0.0;
    refit_later(std::clamp(1 + ahead_s / std::max(1e-9, to_s(now_ns - free_ns)), kHoldGrowth, kGrowthFar));
    if (knocks && !explained()) refit_after_knock();
  } else if (!modal_fitted) {
    return false;
  }
  const double left_before = std::exchange(verdict, {}).worst_left;
  verdict.worst_left = modal_left(end_ns, &verdict.worst_channel);
  if (verdict.worst_left <= 1) {
    compare_halves();
    verdict.worst_left = modal_left(end_ns, &verdict.worst_channel);
    if (!explained()) refit_soon();
  }
  const bool believes = believed(left_before), waits = !believes || !determined() || knock_ns > refitted_ns;
  verdict.settles_in_s = !waits || !std::isfinite(verdict.worst_left) ? kNaN
                         : verdict.worst_left > 1                     ? std::log(verdict.worst_left) / slowest_rate()
                         : !believes                                  ? to_s(believe_at_ns - now_ns)
                                                                      : kNaN;
  if (waits || out_of_search()) return true;
  const std::int64_t counts_ns = count_from(end_ns);
  if (counts_ns == INT64_MIN) return true;
  at.settled_ns = counts_ns;
  verdict.settled = true;
  at.verdict_ns = end_ns;
  states.begin_to_measure();
  live.begin_to_count();
  std::fill(transient.begin(), transient.end(), 0.0);
  data.take_drive(modal.omega(), {modal.rate(), modal.t0_ns()});
  if (states.awaits_reason()) emit(EndedBy::drive_changed);
  refit_later(hums() ? kHoldGrowth : kGrowthMeasuring);
  take_transient_out(end_ns);
  count_anew();
  // Again, where the data that count contradict the frequency at which the transient was taken out of them.
  fits_left = std::max(fits_left, kRefits);
  for (int i = 0; i < kRefits && tracked() && !same_drive() && follow_drive(); ++i) {
    take_transient_out(end_ns);
    count_anew();
  }
  remember_modes();
  return true;
}

std::int64_t Pipeline::Impl::count_from(std::int64_t end_ns) const {
  // The data count from the earliest instant at which a verdict would have been right. Where that leaves too few they
  // count from further back: there what is taken out is at most kMostTakenOut times what may be left.
  const auto quarter_ns = to_ns(period_s() / kQuarters);
  const std::int64_t all = (end_ns - modal.t0_ns()) / quarter_ns;
  const auto back_to = [&](double allowed) {
    std::int64_t back = 0, too_far = all + 1;
    while (too_far - back > 1) {
      const std::int64_t middle = back + (too_far - back) / 2;
      (modal_left(end_ns - middle * quarter_ns, nullptr) > allowed ? too_far : back) = middle;
    }
    return back;
  };
  const std::int64_t back = std::max(back_to(1.0), std::min<std::int64_t>(2 * kQuarters, back_to(kMostTakenOut)));
  return back < kFewestQuarters ? INT64_MIN : end_ns - back * quarter_ns;
}

// Few readings more than regressors are explained by any poles.
bool Pipeline::Impl::determined() const {
  for (int c = 0; c < channel_count; ++c)
    if (modal.usable(c) && modal.samples(c) < kPerParameter * modal.parameters()) return false;
  return true;
}

// Whether a channel's noise is hidden by its rounding.
bool Pipeline::Impl::rounded(int c) const {
  const double step = live[c].intake().step();
  return modal.usable(c) && std::isfinite(step) && modal.variance(c) < step * step * kRounded;
}

// Rounding is no noise: it may lead a fit astray, and another with some more data again elsewhere. What is said of a
// sudden where readings are rounded is asked of a second fit.
bool Pipeline::Impl::believed(double left_before) {
  if (verdict.worst_left > 1) {
    believe_at_ns = INT64_MIN;
    return false;
  }
  if (believe_at_ns == INT64_MIN) {
    bool any = false;
    for (int c = 0; c < channel_count; ++c) any = any || rounded(c);
    if (!any || !(left_before > kSudden)) return true;
    believe_at_ns = now_ns + std::max(to_ns(kAgainPeriods * period_s()),
                                      static_cast<std::int64_t>(kAgain * static_cast<double>(now_ns - free_ns)));
    modal_refit_at_ns = believe_at_ns;
  }
  return now_ns >= believe_at_ns;
}

void Pipeline::Impl::refit_later(double growth) {
  modal_refit_at_ns = free_ns + static_cast<std::int64_t>(growth * static_cast<double>(now_ns - free_ns));
}

// Not before a period has gone by.
void Pipeline::Impl::refit_soon() { modal_refit_at_ns = std::min(modal_refit_at_ns, now_ns + to_ns(period_s())); }

// More data tell better what the transient was: now and then, while all since the hold's beginning are there and what
// is not known of it is a part of the uncertainty that matters.
void Pipeline::Impl::refit_measuring(std::int64_t end_ns) {
  if (quiet_ns == INT64_MIN || now_ns < modal_refit_at_ns || doubtful_quarters() > 0) return;
  if (history[history.begin()].t_ns > modal.t0_ns()) {
    modal_refit_at_ns = INT64_MAX;
    return;
  }
  // What grows apart from the steady motion as slowly as it decays shows while it decays.
  double slowest = slowest_rate();
  const auto chain = chain_poles();
  for (const Complex& pole : chain) slowest = std::min(slowest, -pole.real());
  const bool seen = slowest * to_s(now_ns - free_ns) > kSeenThrough;
  const bool last = seen && !(hums() || transient_matters());
  fits_left = std::min(kFitsMeasuring, fits_affordable(modal.poles().size()));
  best_poles.assign(extra_poles.begin(), extra_poles.end());
  best_poles.insert(best_poles.end(), modal_poles.begin(), modal_poles.end());
  feed_modes();
  solve_modes();
  if (!same_drive()) static_cast<void>(follow_drive());
  const double refined = refine_poles(modal.misfit(), 1);
  // A verdict by too few data may have had poles far from the chain's as it shows by now.
  keep_alive(chain, trial_poles);
  if (fits_left > 0 && !trial_poles.empty())
    if (const double other = try_poles(modal.omega(), refined); other < refined) refine_poles(other, kManyRefinements);
  take_best_poles();
  modal.propagate_poles(!from_motion());
  refit_later(hums() ? kHoldGrowth : kGrowthMeasuring);
  if (premature() && !mend_verdict(end_ns)) return;
  take_transient_out(end_ns);
  count_anew();
  remember_modes();
  if (last) modal_refit_at_ns = INT64_MAX;
}

// Whether a better fit says that at the verdict more than allowed was left of the transient, by kSure standard
// deviations; then the channel and by how much.
bool Pipeline::Impl::premature() {
  if (!explained()) return false;
  double most = 1.0;
  for (int c = 0; c < channel_count; ++c) {
    if (!windows.usable(c) || !modal.usable(c)) continue;
    if (shows_drive(rig.channels[static_cast<std::size_t>(c)])) continue;
    const ModalFit::Left left = modal.left(c, at.verdict_ns);
    const double allowed = allowed_left(c);
    if ((left.swing - kSure * left.u) / allowed <= most) continue;
    most = (left.swing - kSure * left.u) / allowed;
    taken_back = {at.verdict_ns, c, left.swing / allowed};
  }
  return most > 1;
}

// After a verdict that was premature: where the same fit says that the rig has settled since, the data count from there
// (true); else the rig settles again, in the same hold and by the fit that has taken the verdict back (false).
bool Pipeline::Impl::mend_verdict(std::int64_t end_ns) {
  verdict.worst_left = modal_left(end_ns, &verdict.worst_channel);
  if (verdict.worst_left <= 1) {
    if (const std::int64_t counts_ns = count_from(end_ns); counts_ns != INT64_MIN) {
      at.settled_ns = counts_ns;
      at.verdict_ns = end_ns;
      return true;
    }
  }
  verdict.settled = false;
  verdict.settles_in_s = kNaN;
  states.take_back();
  data.stop_counting(end_ns);
  tracker.stop_counting();
  quiet_ns = INT64_MIN;
  const std::int64_t begin_ns = std::max({at.steady_ns, end_ns - to_ns(rig.memory_s), history[history.begin()].t_ns});
  rebuild_blocks(begin_ns, end_ns);
  refitted_ns = now_ns;
  refit_later(kHoldGrowth);
  return false;
}

// Tries the frequency of the data that count in the modal fit. The fit has seen more data than these, so it keeps its
// own frequency unless the other explains all of them better.
bool Pipeline::Impl::follow_drive() {
  best_poles.assign(modal.poles().begin(), modal.poles().end());
  trial_poles = best_poles;
  modal_rate = data.drift().rate;
  const double before = modal.misfit();
  return try_poles(data.omega_at(modal_from_ns, omega()), before) < before;
}

// Whether the frequency of the modal fit still is that of the drive: the difference turns no phasor by what shows, or
// is no more than the data that count leave open; the modal fit has seen more than these.
bool Pipeline::Impl::same_drive() const {
  const double off = std::abs(data.omega_at(modal.t0_ns(), omega()) - modal.omega()),
               seen_s = to_s(now_ns - modal.t0_ns());
  const double faster = std::abs(data.drift().rate - modal.rate());
  if (from_motion() && faster == 0 && off < kOwnOmega * tracker.u_omega()) return true;
  const double turned = (off + 0.5 * faster * seen_s) * seen_s;
  for (int c = 0; c < channel_count; ++c)
    if (modal.usable(c) &&
        turned * std::abs(modal.phasor(c, 1)) > kTurned * std::sqrt(modal.variance(c) * 2 / modal.samples(c)))
      return false;
  return true;
}

// Whether in any channel what is not known of the transient adds to the variance of the phasor.
bool Pipeline::Impl::transient_matters() const {
  for (int c = 0; c < channel_count; ++c) {
    const HarmonicFit fit = data.fit_counted(c);
    if (!fit.usable || !modal.usable(c)) continue;
    if (transient_covariance(c, fit.samples).trace() > kMatters * fit.covariance.trace()) return true;
  }
  return false;
}

// Of p_1 and q_1 of N samples, referred to the modal fit's zero of time.
Eigen::Matrix2d Pipeline::Impl::transient_covariance(int c, double samples) const {
  return 4 / (samples * samples) * modal.spread(c, overlap[static_cast<std::size_t>(c)]);
}

// Builds the blocks anew from the history, the transient subtracted.
void Pipeline::Impl::take_transient_out(std::int64_t end_ns) {
  const std::int64_t begin_ns = std::max(at.settled_ns, end_ns - to_ns(rig.memory_s));
  quiet_ns = end_ns;
  modal.propagate_poles(!from_motion());
  fade_modes(begin_ns);
  for (std::size_t m = 0; m < modal.poles().size(); ++m)
    if (modal.poles()[m].real() < 0) quiet_ns = std::max(quiet_ns, modal.faded_ns(m));
  // What hums is followed as long as it is fitted anew.
  if (hums()) quiet_ns = std::max(quiet_ns, modal_refit_at_ns + to_ns(2 * period_s()));
  for (auto& B : overlap) B.setZero();
  rebuild_blocks(begin_ns, end_ns);
}

void Pipeline::Impl::rebuild_blocks(std::int64_t begin_ns, std::int64_t end_ns) {
  const auto quarter_ns = to_ns(period_s() / kQuarters);
  begin_ns = end_ns - (end_ns - begin_ns + quarter_ns / 2) / quarter_ns * quarter_ns;
  data.restart();
  at.steady_serial = blocks().serials();
  std::uint64_t i = history.first_at(begin_ns);
  for (; begin_ns < end_ns; begin_ns += quarter_ns) {
    data.open(begin_ns);
    for (; i < history.end() && history[i].t_ns < begin_ns + quarter_ns; ++i)
      add_cleaned(history[i].t_ns, history[i].channel, history[i].value);
    data.close();
  }
}

double Pipeline::Impl::add_cleaned(std::int64_t t_ns, int c, double value) {
  if (t_ns < quiet_ns && modal.usable(c)) {
    value -= modal.disturbance(c, t_ns);
    modal.overlap_at(t_ns, overlap[static_cast<std::size_t>(c)]);
  }
  data.add(c, t_ns, value);
  return value;
}

}  // namespace dwell
