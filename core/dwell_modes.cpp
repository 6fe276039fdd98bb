#include <utility>

#include "core/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr double kGrowth = 1.25;                  // of the hold, before its poles are refined again
constexpr double kGrowthFar = 2.0, kAhead = 0.5;  // … at most, and part of the time expected to be left
constexpr double kSkipped = 0.15;  // of the hold, its violent beginning: what has decayed by then needs no mode …
constexpr double kSkippedMore = 0.1,
                 kSkippedMost = 0.6;  // … and more of it each time that the fit does not explain the data
constexpr double kGone = 1e-6;        // of an amplitude by then
constexpr double kTrust =
    0.05;  // relative change of a pole in one step of its refinement, as far as the data leave it open
constexpr int kRefinements = 2;  // steps each time, at most
constexpr std::size_t kExtraPoles = 2;
constexpr double kSearchPeriods = 10.0, kSearchHarmonics = 12.0;  // where a pole beside the chain's is looked for
constexpr double kSureOfLine = 9.0;                               // exp(-9): once in 8000 searches noise alone
constexpr double kMainsFirst = 1.2;
constexpr double kBeside = 2.0;                                                 // half cycles over the search
constexpr double kLongSeen = 60.0, kHardlyDecayed = 0.3, kMainsWander = 0.004;  // relative, of the mains' frequency
constexpr int kManyRefinements = 8;                                             // where the poles are far off
constexpr double kPenalty = 50.0;         // of the misfit, for each pole beside the chain's
constexpr double kSame = 0.3;             // rad over the fit, by which two poles must differ
constexpr double kNear = 0.1;             // relative, of a chain's pole to one that the data show
constexpr double kConverged = 0.1;        // of the uncertainty of a pole
constexpr double kGrowthMeasuring = 2.0;  // the same after the verdict
constexpr double kMatters = 0.05;         // of the variance
constexpr double kTurned = 0.1;           // standard deviations
constexpr int kTurns = 4;                 // of the fit at a better frequency, at most
constexpr double kSpeaksAgainst = 6.0;    // in N ln σ², of χ²(1)
constexpr double kSafety = 0.8;           // of what is allowed: that is itself only estimated
constexpr double kSure = 3.0;             // standard deviations of what may be left of the transient
constexpr double kSureOfNoise = 4.0;
constexpr double kMostTakenOut = 8.0;       // of what may be left, where data begin to count
constexpr double kNegligible = 1e-3;        // of the tolerance: nothing is subtracted any more …
constexpr double kNegligibleOfNoise = 0.2;  // … or of the uncertainty of the phasor
constexpr double kUnsure = 1.0;             // periods at the beginning of a hold …
constexpr double kShortest = 2.0;           // … and after these before anything is said

// Angular frequencies of mains hum and its first harmonics, of either kind.
double mains(std::size_t k) {
  return kTwoPi * (k < kMains / 2 ? 50.0 * static_cast<double>(k + 1) : 60.0 * static_cast<double>(k - kMains / 2 + 1));
}

}  // namespace

double Pipeline::Impl::drive_omega() {
  if (!tracked()) return omega;
  const int from = blocks.index_of(steady_serial + static_cast<std::int64_t>(kUnsure * kQuarters)), to = blocks.count();
  double w = omega;
  if (from >= to) return w;
  const std::int64_t middle_ns =
      blocks.block(from).begin_ns + (blocks.block(to - 1).end_ns - blocks.block(from).begin_ns) / 2;
  for (int step = 0; step < 3; ++step) {
    blocks.sum_channel(drive_channel, from, to, w, middle_ns, window);
    const HarmonicFit fit = fit_harmonics(window, drive_channel, H, blocks.reference(drive_channel));
    if (!(fit.information > 0)) return w;
    const double delta = fit.score / fit.information;
    w = within_search(rig, w + delta);
    if (std::abs(delta) * std::sqrt(fit.information) < 0.1) break;
  }
  return w;
}

// Shows the modal fit the samples that it has not seen.
void Pipeline::Impl::feed_modes() {
  for (; modal_next < history.end(); ++modal_next) {
    const SampleHistory::Sample& s = history[modal_next];
    if (readings[static_cast<std::size_t>(s.channel)].usable) modal.add(s.channel, s.t_ns, s.value);
  }
}

double Pipeline::Impl::fit_modes(double w, std::span<const Complex> poles) {
  modal.restart(w, modal_from_ns, poles);
  modal_next = history.first_at(modal_from_ns);
  feed_modes();
  solve_modes();
  return modal.misfit();
}

void Pipeline::Impl::solve_modes() {
  for (int c = 0; c < channel_count; ++c)
    // What is imposed has no transient.
    if (const auto i = static_cast<std::size_t>(c); readings[i].usable)
      modal.solve(c, shows_drive(rig.channels[i]) ? 0.0 : ranges[i], ranges[i]);
}

// The poles of the chain that the steady motion tells of, as far as known; where there are none, nothing.
std::span<const Complex> Pipeline::Impl::chain_poles() {
  for (int c = 0; c < channel_count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (rig.channels[i].measures != Quantity::auxiliary && !modal.usable(c)) return {};
    observed(c) = modal.usable(c) ? as_observed(rig, c, modal.phasor(c, 1), modal.omega(), 1) : Complex{};
  }
  time_constant_s = identified_time_constant(modal.omega());
  return decay.poles();
}

// The poles found beside the chain's, then those of `poles` that have not decayed to nothing where the fit begins.
void Pipeline::Impl::keep_alive(std::span<const Complex> poles, std::vector<Complex>& out) const {
  const double skipped_s = to_s(modal_from_ns - steady_ns);
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

bool Pipeline::Impl::refit_modes() {
  const std::int64_t oldest_ns = history[history.begin()].t_ns, held_ns = now_ns - steady_ns;
  // The first period may hold the end of what was before.
  const std::int64_t skipped_ns =
      std::max(to_ns(kUnsure * period_s()), static_cast<std::int64_t>(modal_skipped * static_cast<double>(held_ns)));
  modal_from_ns = std::max(steady_ns + skipped_ns, oldest_ns);
  for (double& range : ranges) range = 0.0;
  for (auto i = history.first_at(modal_from_ns); i < history.end(); ++i) {
    const SampleHistory::Sample& s = history[i];
    const auto c = static_cast<std::size_t>(s.channel);
    ranges[c] = std::max(ranges[c], std::abs(s.value - blocks.reference(s.channel)));
  }
  const double w = drive_omega();
  if (modal_poles.empty()) {
    // From the windows' mean, the first time.
    if (decay.poles().empty()) return false;
    modal_poles.assign(decay.poles().begin(), decay.poles().end());
  }
  // Where poles may come from, until some explain the data: those so far, of which the ones that show nowhere are the
  // chain's as now identified; that chain; the same without what was found beside it; the chain that the latest third
  // tells of, without any modes.
  double best = INFINITY;
  kept_extras = extra_poles;
  kept_poles.clear();
  const bool fitted = modal.usable(drive_channel) && modal.t0_ns() >= steady_ns;
  for (int candidate = 0; candidate < 4; ++candidate) {
    extra_poles.clear();
    if (candidate < 2) extra_poles = kept_extras;
    std::span<const Complex> poles = modal_poles;
    if (candidate == 3) {
      const std::int64_t from_ns = std::exchange(modal_from_ns, std::max(modal_from_ns, now_ns - held_ns / 3));
      fit_modes(w, {});
      modal_from_ns = from_ns;
    }
    if (candidate == 0 && fitted) renew_silent_poles();
    if (candidate > 0) poles = chain_poles();
    if (poles.empty()) continue;
    keep_alive(poles, best_poles);
    const double misfit = refine_poles(w, fit_modes(w, best_poles), candidate == 0 ? kRefinements : kManyRefinements);
    const double penalized = misfit + kPenalty * static_cast<double>(extra_poles.size());
    if (penalized < best) {
      best = penalized;
      kept_poles = best_poles;
      spare_poles = extra_poles;
      if (explained()) break;
    }
  }
  if (kept_poles.empty()) return false;
  if (best_poles != kept_poles) fit_modes(w, kept_poles);
  best_poles = kept_poles;
  extra_poles = spare_poles;
  if (find_extra_pole()) {
    std::rotate(extra_poles.begin(), extra_poles.end() - 1, extra_poles.end());
    best_poles.insert(best_poles.begin(), extra_poles.front());
    refine_poles(w, fit_modes(w, best_poles), kManyRefinements);
  }
  take_best_poles();
  judge_extra_poles(w);
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

// Whether every channel's residuals are no more than its noise.
bool Pipeline::Impl::explained() const {
  for (int c = 0; c < channel_count; ++c)
    if (modal.usable(c) && !shows_drive(rig.channels[static_cast<std::size_t>(c)]) && unexplained(c) > 0) return false;
  return true;
}

double Pipeline::Impl::unexplained(int c) const {
  const Noise& noise = noises[static_cast<std::size_t>(c)];
  const double by_noise =
      modal.variance(c) - noise.variance * (1 + kSureOfNoise * std::sqrt(2 / std::max(1.0, noise.freedom)));
  const double by_decay =
      noise.earlier - noise.later * (1 + kSureOfNoise * std::sqrt(2 * 2 / std::max(1.0, noise.in_half)));
  return std::max(by_noise, by_decay);
}

// What a wrong set of poles leaves over decays, noise does not: the residuals of the earlier half of the fit and of the
// later.
void Pipeline::Impl::compare_halves() {
  const std::int64_t middle_ns = modal.t0_ns() + (now_ns - modal.t0_ns()) / 2;
  for (Noise& noise : noises) noise.earlier = noise.later = noise.in_half = 0.0;
  for (auto i = history.first_at(modal.t0_ns()); i < modal_next; ++i) {
    const SampleHistory::Sample& s = history[i];
    if (!modal.usable(s.channel)) continue;
    const double r = modal.residual(s.channel, s.t_ns, s.value);
    Noise& noise = noises[static_cast<std::size_t>(s.channel)];
    (s.t_ns < middle_ns ? noise.earlier : noise.later) += r * r;
    noise.in_half += 0.5;
  }
  for (Noise& noise : noises) {
    if (!(noise.in_half > 0)) continue;
    // Each half has half of the fit's parameters.
    const double freedom = std::max(1.0, noise.in_half - 0.5 * static_cast<double>(modal.parameters()));
    noise.earlier /= freedom;
    noise.later /= freedom;
  }
}

// Takes trial_poles if they explain the data better; the fit is that of best_poles afterwards.
double Pipeline::Impl::try_poles(double w, double best) {
  const double misfit = fit_modes(w, trial_poles);
  if (misfit < best || !std::isfinite(best)) {
    best_poles = trial_poles;
    return misfit;
  }
  fit_modes(w, best_poles);
  return best;
}

double Pipeline::Impl::refine_poles(double w, double misfit, int steps) {
  double best = misfit;
  for (int i = 0; i < steps; ++i) {
    const auto moved = modal.refined(kTrust);
    if (modal.converged() < kConverged) break;
    trial_poles.assign(moved.begin(), moved.end());
    const double better = try_poles(w, best);
    if (!(better < best)) break;
    best = better;
  }
  compare_halves();
  return best;
}

// What the fit leaves over may hold an oscillation that the chain does not have: a bracket that rings, mains hum. The
// strongest line of the beginning of the fit, where it is strongest, on top of what noise shows now and then.
bool Pipeline::Impl::find_extra_pole() {
  if (extra_poles.size() >= kExtraPoles) return false;
  const double stretch_s = std::min(to_s(now_ns - modal.t0_ns()), kSearchPeriods * period_s());
  const std::int64_t until_ns = modal.t0_ns() + to_ns(stretch_s);
  const double grid = std::numbers::pi / stretch_s;
  double strongest = 0.0, found = 0.0;
  for (int c = 0; c < channel_count; ++c) {
    if (!modal.usable(c)) continue;
    const bool imposed = shows_drive(rig.channels[static_cast<std::size_t>(c)]);
    const double rate = modal.samples(c) / std::max(1e-9, to_s(now_ns - modal.t0_ns()));
    const auto lines =
        static_cast<std::size_t>(std::clamp(std::min(std::numbers::pi * 0.9 * rate, kSearchHarmonics * omega) / grid,
                                            0.0, static_cast<double>(spectrum.size() - kMains)));
    std::fill(spectrum.begin(), spectrum.end(), Complex{});
    double squares = 0.0, count = 0.0;
    for (auto i = history.first_at(modal.t0_ns()); i < history.end() && history[i].t_ns < until_ns; ++i) {
      const SampleHistory::Sample& s = history[i];
      if (s.channel != c) continue;
      const double r = modal.residual(c, s.t_ns, s.value), u = to_s(s.t_ns - modal.t0_ns());
      const Complex step = std::polar(1.0, grid * u);
      Complex turn = r * step;
      for (std::size_t k = kMains; k < kMains + lines; ++k, turn *= step) spectrum[k] += turn;
      for (std::size_t k = 0; k < kMains; ++k) spectrum[k] += r * std::polar(1.0, mains(k) * u);
      squares += r * r;
      count += 1.0;
    }
    if (count < 16) continue;
    // Of white noise each is distributed as exp(-P).
    const double sure = std::log(static_cast<double>(lines) + 1) + kSureOfLine;
    for (std::size_t k = 0; k < (imposed ? kMains : kMains + lines); ++k) {
      // The mains are believed first: what they do is seen at their aliases as well.
      const double P = std::norm(spectrum[k]) / squares * (k < kMains ? kMainsFirst : 1.0);
      if (P - sure <= strongest) continue;
      // Beside a harmonic it would be the drive's own frequency that is a little off.
      const double line = k < kMains ? mains(k) : grid * static_cast<double>(k - kMains + 1);
      if (std::abs(std::remainder(line, omega)) < kBeside * grid && line < (H + 0.5) * omega) continue;
      strongest = P - sure;
      found = line;
    }
  }
  if (found == 0) return false;
  extra_poles.emplace_back(-1 / stretch_s, found);
  return true;
}

// An oscillation that does not decay is no transient. At the mains' frequencies that is believed unless the data speak
// against it; at others after a long time.
void Pipeline::Impl::judge_extra_poles(double w) {
  const double seen_s = to_s(now_ns - modal.t0_ns());
  for (std::size_t i = 0; i < extra_poles.size(); ++i) {
    const Complex pole = extra_poles[i];
    bool of_mains = false;
    for (std::size_t k = 0; k < kMains; ++k)
      of_mains = of_mains || std::abs(pole.imag() - mains(k)) < kMainsWander * mains(k) + 3 * modal.u_pole(i);
    if (of_mains) {
      kept_poles = best_poles;
      const double given = modal.misfit();
      const bool was_steady = pole.real() == 0;
      best_poles[i].real(was_steady ? -1 / seen_s : 0.0);
      const double other = refine_poles(w, fit_modes(w, best_poles), kManyRefinements);
      if (was_steady ? other + kSpeaksAgainst < given : other < given + kSpeaksAgainst) {
        take_best_poles();
      } else {
        best_poles = kept_poles;
        fit_modes(w, best_poles);
        compare_halves();
      }
    } else if (pole.real() != 0 && seen_s > kLongSeen * period_s() &&
               (-pole.real() + 3 * modal.u_pole(i)) * seen_s < kHardlyDecayed) {
      extra_poles[i].real(0.0);
    }
  }
}

// best_poles are those beside the chain, then the chain's.
void Pipeline::Impl::take_best_poles() {
  for (std::size_t i = 0; i < extra_poles.size(); ++i) extra_poles[i] = best_poles[i];
  modal_poles.assign(best_poles.begin() + static_cast<std::ptrdiff_t>(extra_poles.size()), best_poles.end());
}

bool Pipeline::Impl::hums() const {
  return std::any_of(extra_poles.begin(), extra_poles.end(), [](Complex pole) { return pole.real() == 0; });
}

// What may be left of the transient in a channel: the tolerance of its amplitude, or what ten periods' noise hides.
double Pipeline::Impl::allowed_left(int c) const {
  const double span_s = std::max(1e-9, to_s(now_ns - modal.t0_ns()));
  const double in_ten = std::max(1.0, modal.samples(c) / span_s * 10 * period_s());
  const Noise& noise = noises[static_cast<std::size_t>(c)];
  const double floor = std::min({modal.variance(c), noise.variance, noise.in_half > 0 ? noise.later : INFINITY});
  return std::max({rig.tolerance * std::abs(modal.phasor(c, 1)), 3 * std::sqrt(floor * 2 / in_ten), 1e-300});
}

// How much of the transient may be left at t, of what is allowed: the worst of all channels.
double Pipeline::Impl::modal_left(std::int64_t t_ns, int* worst) const {
  double largest = 0.0;
  for (int c = 0; c < channel_count; ++c) {
    if (!readings[static_cast<std::size_t>(c)].usable) continue;
    if (!modal.usable(c)) return INFINITY;
    if (shows_drive(rig.channels[static_cast<std::size_t>(c)])) continue;
    const double allowed = allowed_left(c);
    const ModalFit::Left left = modal.left(c, t_ns);
    double ratio = (left.envelope + kSure * left.u) / (kSafety * allowed);
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
  if (to_s(end_ns - steady_ns) < (kUnsure + kShortest) * 0.99 * period_s()) return true;
  if (modal_poles.empty() || now_ns >= modal_refit_at_ns) {
    if (!refit_modes()) return false;
    // Far from settled there is time.
    const double left = modal_left(end_ns, nullptr);
    const double ahead_s =
        left > 1 && std::isfinite(left) && explained() ? kAhead * std::log(left) / slowest_rate() : 0.0;
    refit_later(std::clamp(1 + ahead_s / std::max(1e-9, to_s(now_ns - steady_ns)), kGrowth, kGrowthFar));
  } else {
    feed_modes();
    solve_modes();
  }
  verdict = {};
  verdict.worst_left = modal_left(end_ns, &verdict.worst_channel);
  if (verdict.worst_left <= 1) {
    compare_halves();
    verdict.worst_left = modal_left(end_ns, &verdict.worst_channel);
    if (!explained()) refit_soon();
  }
  const bool waits = verdict.worst_left > 1;
  verdict.settles_in_s =
      waits && std::isfinite(verdict.worst_left) ? std::log(verdict.worst_left) / slowest_rate() : kNaN;
  if (waits || out_of_search()) return true;
  // The data count from where the same could be said of an earlier instant; further back, where that would leave too
  // few, only as long as what is taken out is no large multiple of what may be left.
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
  if (back < kFewestQuarters) return true;
  settled_ns = end_ns - back * quarter_ns;
  verdict.settled = true;
  verdict_ns = end_ns;
  enter(State::measuring);
  std::fill(transient.begin(), transient.end(), 0.0);
  omega = modal.omega();
  if (pending) emit(EndedBy::drive_changed);
  refit_later(kGrowthMeasuring);
  take_transient_out(end_ns);
  count_anew();
  // Again, now that the frequency is known from data taken at it.
  for (int i = 0; i < kTurns && tracked(); ++i) {
    const double w = drive_omega();
    if (same_drive(w)) break;
    fit_modes(w, modal.poles());
    take_transient_out(end_ns);
    count_anew();
  }
  return true;
}

double Pipeline::Impl::slowest_rate() const {
  double slowest = INFINITY;
  for (const Complex& pole : modal.poles())
    if (pole.real() < 0) slowest = std::min(slowest, -pole.real());
  return slowest;
}

void Pipeline::Impl::refit_later(double growth) {
  modal_refit_at_ns = steady_ns + static_cast<std::int64_t>(growth * static_cast<double>(now_ns - steady_ns));
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
  const bool last = !(hums() || transient_matters());
  best_poles.assign(extra_poles.begin(), extra_poles.end());
  best_poles.insert(best_poles.end(), modal_poles.begin(), modal_poles.end());
  double misfit = NAN;
  const double w = drive_omega();
  if (same_drive(w)) {
    feed_modes();
    solve_modes();
    misfit = modal.misfit();
  } else {
    misfit = fit_modes(w, best_poles);
  }
  refine_poles(modal.omega(), misfit, 1);
  take_best_poles();
  refit_later(kGrowthMeasuring);
  take_transient_out(end_ns);
  count_anew();
  if (last) modal_refit_at_ns = INT64_MAX;
}

// Whether the frequency of the modal fit still is that of the drive: the difference turns no phasor by what shows.
bool Pipeline::Impl::same_drive(double w) const {
  const double turned = std::abs(w - modal.omega()) * to_s(now_ns - modal.t0_ns());
  for (int c = 0; c < channel_count; ++c)
    if (modal.usable(c) &&
        turned * std::abs(modal.phasor(c, 1)) > kTurned * std::sqrt(modal.variance(c) * 2 / modal.samples(c)))
      return false;
  return true;
}

// Whether in any channel what is not known of the transient adds to the variance of the phasor.
bool Pipeline::Impl::transient_matters() const {
  for (int c = 0; c < channel_count; ++c) {
    const HarmonicFit fit = fit_harmonics(counted, c, H, 0.0);
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
  const auto quarter_ns = to_ns(period_s() / kQuarters);
  std::int64_t begin_ns = std::max(settled_ns, end_ns - to_ns(rig.memory_s));
  begin_ns = end_ns - (end_ns - begin_ns) / quarter_ns * quarter_ns;
  quiet_ns = end_ns;
  fade_modes(begin_ns);
  for (std::size_t m = 0; m < modal.poles().size(); ++m)
    if (modal.poles()[m].real() < 0) quiet_ns = std::max(quiet_ns, modal.faded_ns(m));
  // What hums is followed as long as it is fitted anew.
  if (hums()) quiet_ns = std::max(quiet_ns, modal_refit_at_ns + to_ns(2 * period_s()));
  blocks.restart();
  steady_serial = blocks.serials();
  for (auto& B : overlap) B.setZero();
  std::uint64_t i = history.first_at(begin_ns);
  for (; begin_ns < end_ns; begin_ns += quarter_ns) {
    blocks.open(begin_ns, begin_ns + quarter_ns, omega);
    for (; i < history.end() && history[i].t_ns < begin_ns + quarter_ns; ++i)
      add_cleaned(history[i].t_ns, history[i].channel, history[i].value);
    blocks.close();
  }
}

double Pipeline::Impl::add_cleaned(std::int64_t t_ns, int c, double value) {
  if (t_ns < quiet_ns && modal.usable(c)) {
    value -= modal.disturbance(c, t_ns);
    modal.overlap_at(t_ns, overlap[static_cast<std::size_t>(c)]);
  }
  blocks.add(c, t_ns, value);
  return value;
}

}  // namespace dwell
