// The input of the transient's model (core/transient/transient_model.hpp), and what its verdicts do to the dwell: data
// begin to count, the transient is taken out of them, a verdict is taken back.
#include <utility>

#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr double kMatters = 0.05;    // part of a phasor's variance from which the unknown transient matters
constexpr double kOfAdding = 500.0;  // multiplications: the cost of putting a sample into its block

}  // namespace

HoldNow Pipeline::Impl::hold_now() {
  for (int c = 0; c < live.count(); ++c) {
    const ChannelIntake& intake = live[c].intake();
    const auto i = static_cast<std::size_t>(c);
    fitted_channels[i] = {.watched = windows.usable(c),
                          .imposed = live.on_table()[i] != 0,
                          .reference = blocks().reference(c),
                          .refresh_half_s = intake.refresh_half_s(),
                          .widest_refresh_half_s = intake.widest_refresh_half_s(),
                          .transaction = live.transaction_of(c),
                          .step = intake.step(),
                          .sampling = live[c].sampling()};
  }
  return {now_ns, at.steady_ns, omega(), !from_motion(), drive_channel(), fitted_channels};
}

SeenFrequency Pipeline::Impl::drive_omega() const {
  if (!inexact()) return {omega()};
  const int from = blocks().index_of(at.steady_serial + static_cast<std::int64_t>(kUnsure * kQuarters)),
            to = blocks().count();
  double w = omega();
  if (from >= to) return {w};
  const std::int64_t middle_ns =
      blocks().block(from).begin_ns + (blocks().block(to - 1).end_ns - blocks().block(from).begin_ns) / 2;
  for (int step = 0; step < 3; ++step) {
    const HarmonicFit fit = data.fit(drive_channel(), from, to, w, middle_ns);
    if (!(fit.information > 0)) return {w};
    const double information = fit.information + reference.stated().information();
    const double delta = (fit.score + reference.stated().score(w)) / information;
    w = within_search(rig, w + delta);
    if (std::abs(delta) * std::sqrt(information) < 0.1) break;
  }
  return {w, data.seen_drift(from, w, middle_ns), middle_ns};
}

bool Pipeline::Impl::settle_by_modes(std::int64_t end_ns) {
  if (rig.mass_count() == 0) return false;
  const HoldNow now = hold_now();
  // Windows alone would settle too soon.
  if (modes.too_early(end_ns, now)) return true;
  if (modes.wants_refit(end_ns, now) && !modes.refit(drive_omega(), end_ns, now)) return false;
  if (!modes.fitted()) return false;
  const TransientModel::Judgement judged = modes.judge(verdict.worst_left, end_ns, now);
  verdict = judged.verdict;
  if (!judged.counts_from_ns || out_of_search()) return true;
  at.settled_ns = *judged.counts_from_ns;
  verdict.settled = true;
  at.verdict_ns = end_ns;
  if (states.awaits_reason()) emit(EndedBy::drive_changed);
  states.begin_to_measure();
  live.begin_to_count();
  errors_in_motion.begin(at.settled_ns);
  windows.forget_left();
  data.take_drive(modes.fit().omega(), {modes.fit().rate(), modes.fit().t0_ns()});
  modes.begin_measuring(hold_now());
  take_transient_out(end_ns);
  resum();
  // Repeated where the data that count contradict the frequency at which the transient was taken out.
  modes.allow_following();
  for (int i = 0; i < TransientModel::kMostFollowed && inexact(); ++i) {
    if (!modes.follow_drive(counted_omega(), hold_now())) break;
    take_transient_out(end_ns);
    resum();
  }
  modes.remember_modes(hold_now());
  return true;
}

// Fits the transient again when the data have grown. Only while the data since the hold's beginning are kept, and the
// unknown part of the transient matters in the uncertainty.
void Pipeline::Impl::refit_measuring(std::int64_t end_ns) {
  const HoldNow now = hold_now();
  if (doubtful_quarters() > 0 || !modes.wants_refit_measuring(now)) return;
  const bool last = modes.refit_measuring(counted_omega(), transient_matters(), now);
  if (modes.takes_back(at.verdict_ns, now) && !mend_verdict(end_ns)) return;
  take_transient_out(end_ns);
  resum();
  modes.remember_modes(hold_now());
  if (last) modes.end_refits();
}

// Mends a premature verdict. If the same fit says that the rig has settled since, the data count from there (true).
// Else the rig settles again, in the same hold and with the fit that took the verdict back (false).
bool Pipeline::Impl::mend_verdict(std::int64_t end_ns) {
  if (const auto counts_ns = modes.mend(end_ns, hold_now(), verdict)) {
    at.settled_ns = *counts_ns;
    at.verdict_ns = end_ns;
    errors_in_motion.begin(at.settled_ns);
    return true;
  }
  verdict.settled = false;
  verdict.settles_in_s = kNaN;
  states.take_back();
  modes.settle_again(hold_now());
  data.stop_counting(end_ns);
  tracker.stop_counting();
  const std::int64_t begin_ns = std::max({at.steady_ns, end_ns - to_ns(rig.memory_s), history[history.begin()].t_ns});
  rebuild_blocks(begin_ns, end_ns);
  return false;
}

// Whether the unknown part of the transient adds to the variance of some channel's phasor.
bool Pipeline::Impl::transient_matters() const {
  for (int c = 0; c < live.count(); ++c) {
    const HarmonicFit fit = data.fit_counted(c);
    if (!fit.usable || !modes.fit().usable(c)) continue;
    if (modes.removal().covariance(c, fit.samples).trace() > kMatters * fit.covariance.trace()) return true;
  }
  return false;
}

void Pipeline::Impl::take_transient_out(std::int64_t end_ns) {
  const std::int64_t begin_ns = std::max(at.settled_ns, end_ns - to_ns(rig.memory_s));
  modes.take_out(begin_ns, end_ns, hold_now());
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
    for (; i < history.end() && history[i].t_ns < begin_ns + quarter_ns; ++i) {
      add_cleaned(history[i].t_ns, history[i].channel, history[i].value);
      history.spend(kOfAdding);
    }
    data.close();
  }
}

double Pipeline::Impl::add_cleaned(std::int64_t t_ns, int c, double value) {
  value = modes.clean(c, t_ns, value);
  data.add(c, t_ns, value);
  return value;
}

}  // namespace dwell
