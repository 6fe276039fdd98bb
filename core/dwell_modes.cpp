#include "core/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr double kGrowth = 1.12;   // of the hold, before its poles are refined again
constexpr double kTrust = 0.05;    // relative change of a pole in one step of its refinement, as far as the data leave it open
constexpr int kRefinements = 2;    // steps each time
constexpr double kGrowthMeasuring = 1.5;  // the same after the verdict …
constexpr double kLongest = 8.0;          // … until the hold is so many times as long as it took to settle
constexpr double kSafety = 0.8;           // of what is allowed: that is itself only estimated
constexpr double kSure = 3.0;      // standard deviations of what may be left of the transient
constexpr double kNegligible = 1e-3;  // of what is allowed: nothing is subtracted any more
constexpr double kShortest = 2.0;  // periods of a hold before anything is said

}  // namespace

double Pipeline::Impl::drive_omega() {
  if (!tracked()) return omega;
  const int from = std::max(0, blocks.index_of(steady_serial)), to = blocks.count();
  double w = omega;
  if (from >= to) return w;
  const std::int64_t middle_ns = blocks.block(from).begin_ns + (blocks.block(to - 1).end_ns - blocks.block(from).begin_ns) / 2;
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
    if (readings[static_cast<std::size_t>(c)].usable) modal.solve(c, ranges[static_cast<std::size_t>(c)]);
}

// The poles of the chain that the steady motion tells of, as far as known; where there are none, nothing.
std::span<const Complex> Pipeline::Impl::chain_poles() {
  for (int c = 0; c < channel_count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (rig.channels[i].measures != Quantity::auxiliary && !modal.usable(c)) return {};
    observed(c) = modal.usable(c) ? as_observed(rig, c, modal.phasor(c, 1), modal.omega(), 1) : Complex{};
  }
  time_constant_s = identified_time_constant(modal.omega());
  decaying.assign(decay.poles().begin(), decay.poles().end());
  for (Complex& pole : decaying) pole.real(std::min(pole.real(), -1e-3 * std::abs(pole)));
  return decaying;
}

bool Pipeline::Impl::refit_modes() {
  const std::int64_t oldest_ns = history[history.begin()].t_ns;
  modal_from_ns = std::max(steady_ns, oldest_ns);
  for (double& range : ranges) range = 0.0;
  for (auto i = history.first_at(modal_from_ns); i < history.end(); ++i) {
    const SampleHistory::Sample& s = history[i];
    const auto c = static_cast<std::size_t>(s.channel);
    ranges[c] = std::max(ranges[c], std::abs(s.value - blocks.reference(s.channel)));
  }
  const double w = drive_omega();
  best_poles.clear();
  double best = INFINITY;
  if (modal_poles.empty()) {
    // From the windows' mean, the first time.
    if (decay.poles().empty()) return false;
    modal_poles.assign(decay.poles().begin(), decay.poles().end());
    for (Complex& pole : modal_poles) pole.real(std::min(pole.real(), -1e-3 * std::abs(pole)));
  }
  best = fit_modes(w, modal_poles);
  best_poles.assign(modal.poles().begin(), modal.poles().end());
  for (int i = 0; i < 2; ++i) {
    const auto chain = chain_poles();
    if (chain.empty()) break;
    const double misfit = fit_modes(w, chain);
    if (!(misfit < best)) break;
    best = misfit;
    best_poles.assign(modal.poles().begin(), modal.poles().end());
  }
  if (!std::isfinite(best)) return false;
  if (modal.poles().size() != best_poles.size() || !std::equal(best_poles.begin(), best_poles.end(), modal.poles().begin()))
    fit_modes(w, best_poles);
  for (int i = 0; i < kRefinements; ++i) {
    const auto moved = modal.refined(kTrust);
    trial_poles.assign(moved.begin(), moved.end());
    const double misfit = fit_modes(w, trial_poles);
    if (!(misfit < best)) {
      fit_modes(w, best_poles);
      break;
    }
    best = misfit;
    best_poles = trial_poles;
  }
  modal_poles = best_poles;
  return true;
}

// How much of the transient may be left at t, of what is allowed: the worst of all channels.
double Pipeline::Impl::modal_left(std::int64_t t_ns, int* worst) const {
  double largest = 0.0;
  const double span_s = std::max(1e-9, to_s(now_ns - modal.t0_ns()));
  for (int c = 0; c < channel_count; ++c) {
    if (!readings[static_cast<std::size_t>(c)].usable) continue;
    if (!modal.usable(c)) return INFINITY;
    const double in_ten = std::max(1.0, modal.samples(c) / span_s * 10 * period_s());
    const double allowed = std::max(rig.tolerance * std::abs(modal.phasor(c, 1)), 3 * std::sqrt(modal.variance(c) * 2 / in_ten));
    const ModalFit::Left left = modal.left(c, t_ns);
    const double ratio = (left.envelope + kSure * left.u) / std::max(kSafety * allowed, 1e-300);
    if (ratio > largest) {
      largest = ratio;
      if (worst) *worst = c;
    }
  }
  return largest;
}

bool Pipeline::Impl::settle_by_modes(std::int64_t end_ns) {
  if (rig.mass_count() == 0) return false;
  if (modal_poles.empty() || now_ns >= modal_refit_at_ns) {
    if (!refit_modes()) return false;
    refit_later(kGrowth);
  } else {
    feed_modes();
    solve_modes();
  }
  verdict = {};
  verdict.worst_left = modal_left(end_ns, &verdict.worst_channel);
  const bool waits = verdict.worst_left > 1;
  verdict.settles_in_s = waits && std::isfinite(verdict.worst_left) ? std::log(verdict.worst_left) / slowest_rate() : kNaN;
  if (waits || to_s(end_ns - steady_ns) < kShortest * period_s() || out_of_search()) return true;
  // The data count from where the same could be said of an earlier instant.
  const auto quarter_ns = to_ns(period_s() / kQuarters);
  std::int64_t back = 0, too_far = (end_ns - modal.t0_ns()) / quarter_ns + 1;
  while (too_far - back > 1) {
    const std::int64_t middle = back + (too_far - back) / 2;
    (modal_left(end_ns - middle * quarter_ns, nullptr) > 1 ? too_far : back) = middle;
  }
  settled_ns = end_ns - std::max<std::int64_t>(back, 2 * kQuarters) * quarter_ns;
  verdict.settled = true;
  verdict_ns = end_ns;
  enter(State::measuring);
  std::fill(transient.begin(), transient.end(), 0.0);
  omega = modal.omega();
  if (pending) emit(EndedBy::drive_changed);
  refit_later(kGrowthMeasuring);
  take_transient_out(end_ns);
  count_anew();
  return true;
}

double Pipeline::Impl::slowest_rate() const {
  double slowest = INFINITY;
  for (const Complex& pole : modal.poles()) slowest = std::min(slowest, -pole.real());
  return slowest;
}

void Pipeline::Impl::refit_later(double growth) {
  modal_refit_at_ns = modal.t0_ns() + static_cast<std::int64_t>(growth * static_cast<double>(now_ns - modal.t0_ns()));
}

// More data tell better what the transient was: while all since the hold's beginning are there, now and then.
void Pipeline::Impl::refit_measuring(std::int64_t end_ns) {
  if (quiet_ns == INT64_MIN || now_ns < modal_refit_at_ns || drive.windows_since_good() > 0) return;
  if (history[history.begin()].t_ns > modal.t0_ns() || to_s(now_ns - modal.t0_ns()) > kLongest * to_s(verdict_ns - modal.t0_ns())) {
    modal_refit_at_ns = INT64_MAX;
    return;
  }
  best_poles = modal_poles;
  const double best = fit_modes(omega, best_poles);
  const auto moved = modal.refined(kTrust);
  trial_poles.assign(moved.begin(), moved.end());
  if (fit_modes(omega, trial_poles) < best)
    modal_poles = trial_poles;
  else
    fit_modes(omega, best_poles);
  refit_later(kGrowthMeasuring);
  take_transient_out(end_ns);
  count_anew();
}

// Builds the blocks anew from the history, the transient subtracted.
void Pipeline::Impl::take_transient_out(std::int64_t end_ns) {
  const auto quarter_ns = to_ns(period_s() / kQuarters);
  std::int64_t begin_ns = std::max(settled_ns, end_ns - to_ns(rig.memory_s));
  begin_ns = end_ns - (end_ns - begin_ns) / quarter_ns * quarter_ns;
  // Until nothing is left that matters.
  const double left = modal_left(end_ns, nullptr);
  quiet_ns = end_ns + (left > kNegligible ? to_ns(std::min(std::log(left / kNegligible) / slowest_rate(), rig.memory_s)) : 0);
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

void Pipeline::Impl::add_cleaned(std::int64_t t_ns, int c, double value) {
  if (t_ns < quiet_ns && modal.usable(c)) {
    value -= modal.transient(c, t_ns);
    const Eigen::VectorXd& modes = modal.modes_at(t_ns);
    const double angle = modal.omega() * to_s(t_ns - modal.t0_ns());
    overlap[static_cast<std::size_t>(c)].row(0) += std::sin(angle) * modes.transpose();
    overlap[static_cast<std::size_t>(c)].row(1) += std::cos(angle) * modes.transpose();
  }
  blocks.add(c, t_ns, value);
}

}  // namespace dwell
