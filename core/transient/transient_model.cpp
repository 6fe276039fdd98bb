#include "core/transient/transient_model.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/complex.hpp"
#include "core/result/dwell.hpp"

namespace dwell {
namespace {

constexpr double kHoldGrowth = 1.25;  // growth of the hold, at least, before its poles are refined again
constexpr double kGrowthFar = 2.0;    // … at most, and after the verdict
constexpr double kAhead = 0.5;        // part of the expected time left to wait
constexpr int kFitsMeasuring = 12;    // fits of the whole hold at each refit after the verdict, at most
constexpr double kSeenThrough = 3.0;  // decay times of the slowest mode, after which no mode can still hide
constexpr double kOwnOmega = 2.5;  // standard deviations: the fit keeps its ω where the data that count differ by less
constexpr double kTurned = 0.1;    // standard deviations: the fit keeps its ω where the other turns no phasor by more
constexpr double kAfterKnock = 2.5;  // periods from an alarm to the refit
// After a knock that is not explained the hold is fitted again after this part of the time since, at least a period.
constexpr double kLookAgain = 0.25;

int most_modes(const Rig& rig) { return std::min(2 * rig.mass_count() + 2, ModalMotion::kMaxModes); }

}  // namespace

TransientModel::TransientModel(const Rig& rig, const FrequencyPrior& stated, const SampleHistory& history,
                               ChainPoles& chain)
    : chain_(chain),
      fit_(history, static_cast<int>(rig.channels.size()), rig.excitation.harmonics, most_modes(rig), stated),
      noise_(fit_.channels()),
      knocks_(fit_.channels()),
      search_(rig, fit_, noise_),
      lines_(search_, fit_, noise_, rig.masses.size()),
      refit_({chain, fit_, noise_, knocks_, search_, lines_}, rig.masses.size()),
      left_(rig.tolerance, fit_, noise_),
      removal_(rig, fit_),
      shown_(chain, fit_.channels(), fit_.harmonics(), most_modes(rig), stated) {}

void TransientModel::begin_hold(std::int64_t steady_ns) noexcept {
  search_.poles().clear();
  refit_.begin_hold();
  noise_.begin_hold();
  schedule_.begin_hold();
  shown_.begin_hold();
  taken_back_.reset();
  knocks_.begin_hold(steady_ns);
  removal_.stop();
}

bool TransientModel::too_early(std::int64_t end_ns, const HoldNow& now) const noexcept {
  return to_s(end_ns - knocks_.free_since_ns()) < (kUnsure + kPeriodsToTell) * 0.99 * now.period_s();
}

bool TransientModel::wants_refit(std::int64_t end_ns, const HoldNow& now) {
  bool wants = schedule_.due(now.now_ns);
  if (!wants && fitted()) {
    fit_.feed(now.channels);
    fit_.solve(now.channels);
    propagate_poles(now);
    // The last refit had fewer data than the poles' uncertainty now counts: before a verdict refine on all data.
    const std::int64_t made_ns = *schedule_.made_ns();
    const auto grown_ns =
        static_cast<std::int64_t>(RefitSchedule::kAgain * static_cast<double>(made_ns - knocks_.free_since_ns()));
    const bool knocked = !knocks_.alarm_ns() && explained(now) &&
                         knocks_.sees_knock(fit_, noise_, now, end_ns - to_ns(now.period_s() / kQuarters));
    if (knocked) heed_knock(end_ns, now);
    wants = !knocks_.alarmed_since(made_ns) && now.now_ns > made_ns + grown_ns && left_.at(end_ns, now).left <= 1;
  }
  if (wants && !refit_.possible()) {
    schedule_.failed();
    return false;
  }
  return wants;
}

bool TransientModel::refit(const SeenFrequency& seen, std::int64_t end_ns, const HoldNow& now) {
  if (!refit_.make(seen, now)) {
    schedule_.failed();
    if (!chain_.last().empty()) plan_growth(kHoldGrowth, now);
    return false;
  }
  schedule_.made(now.now_ns);
  if (explained(now)) knocks_.clear_alarm();
  propagate_poles(now);
  // The more is left, the longer the next refit can wait.
  const double left = left_.at(end_ns, now).left;
  const double ahead_s =
      left > 1 && std::isfinite(left) && explained(now) ? kAhead * std::log(left) / fit_.slowest_rate() : 0.0;
  const double free_s = std::max(1e-9, to_s(now.now_ns - knocks_.free_since_ns()));
  plan_growth(std::clamp(1 + ahead_s / free_s, kHoldGrowth, kGrowthFar), now);
  if (knocks_.any() && !explained(now)) refit_after_knock(now);
  return true;
}

void TransientModel::propagate_poles(const HoldNow& now) noexcept {
  fit_.fit().propagate_poles(now.omega_given);
  fit_.history().spend(fit_.fit().work_of_poles());
}

TransientModel::Judgement TransientModel::judge(double left_before, std::int64_t end_ns, const HoldNow& now) {
  Judgement judged;
  SettlingDetector::Verdict& verdict = judged.verdict;
  left_.tell(end_ns, now, verdict);
  if (verdict.worst_left <= 1) {
    noise_.compare_halves(fit_, now.now_ns);
    left_.tell(end_ns, now, verdict);
    // The next refit comes a period later at the latest.
    if (!explained(now)) schedule_.plan_no_later_than(now.now_ns + to_ns(now.period_s()));
  }
  const bool believes = schedule_.believes({verdict.worst_left, left_before, left_.rounded(now)}, now.period_s(),
                                           knocks_.free_since_ns(), now.now_ns);
  const bool waits = !believes || !fit_.determined() || knocks_.alarmed_since(*schedule_.made_ns());
  verdict.settles_in_s = !waits || !std::isfinite(verdict.worst_left) ? kNaN
                         : verdict.worst_left > 1 ? std::log(verdict.worst_left) / fit_.slowest_rate()
                         : !believes              ? to_s(*schedule_.confirm_ns() - now.now_ns)
                                                  : kNaN;
  if (!waits) judged.counts_from_ns = left_.counts_from(end_ns, now);
  return judged;
}

// Raises the alarm, and plans a refit for when enough has been seen since.
void TransientModel::heed_knock(std::int64_t end_ns, const HoldNow& now) noexcept {
  knocks_.alarm(end_ns);
  schedule_.plan(end_ns + to_ns(kAfterKnock * now.period_s()));
}

void TransientModel::refit_after_knock(const HoldNow& now) noexcept {
  const auto again_ns =
      static_cast<std::int64_t>(kLookAgain * static_cast<double>(now.now_ns - knocks_.free_since_ns()));
  schedule_.plan_no_later_than(now.now_ns + std::max(to_ns(now.period_s()), again_ns));
}

void TransientModel::begin_measuring(const HoldNow& now) noexcept {
  // A steady line is extrapolated by its phase: it must be fitted anew more often.
  plan_growth(poles().hums() ? kHoldGrowth : kGrowthFar, now);
}

void TransientModel::take_out(std::int64_t from_ns, std::int64_t end_ns, const HoldNow& now) noexcept {
  propagate_poles(now);
  // Steady lines are subtracted until two periods after the next refit is due.
  const std::int64_t followed_ns = schedule_.planned_ns() + to_ns(2 * now.period_s());
  removal_.begin(from_ns, poles().hums() ? std::max(end_ns, followed_ns) : end_ns);
}

// The fit has seen more data than those that count: it keeps its own frequency unless the other explains all of them
// better.
bool TransientModel::follow_drive(const SeenFrequency& counted, const HoldNow& now) {
  if (same_drive(counted, now)) return false;
  search_.best().assign(fit().poles().begin(), fit().poles().end());
  search_.trial() = search_.best();
  fit_.set_rate(counted.rate);
  const double before = fit().misfit();
  return search_.try_trial(counted.at(fit_.from_ns()), before, now) < before;
}

// Whether the fit and the data that count have the same frequency. The difference may turn no phasor by what shows, or
// be no more than the data that count leave open: the fit has seen more than these.
bool TransientModel::same_drive(const SeenFrequency& counted, const HoldNow& now) const noexcept {
  const double off = std::abs(counted.at(fit().t0_ns()) - fit().omega()), seen_s = to_s(now.now_ns - fit().t0_ns());
  const double faster = std::abs(counted.rate - fit().rate());
  if (!now.omega_given && faster == 0 && off < kOwnOmega * counted.u) return true;
  const double turned = (off + 0.5 * faster * seen_s) * seen_s;
  for (int c = 0; c < fit_.channels(); ++c)
    if (fit().usable(c) &&
        turned * std::abs(fit().phasor(c, 1)) > kTurned * std::sqrt(fit().variance(c) * 2 / fit().samples(c)))
      return false;
  return true;
}

bool TransientModel::wants_refit_measuring(const HoldNow& now) noexcept {
  if (!removal_.active() || !schedule_.due(now.now_ns)) return false;
  // Refits need all samples since the begin of the fit.
  const SampleHistory& history = fit_.history();
  if (history[history.begin()].t_ns <= fit().t0_ns()) return true;
  schedule_.plan_no_more();
  return false;
}

bool TransientModel::refit_measuring(const SeenFrequency& counted, bool matters, const HoldNow& now) {
  // A slow mode separates from the steady motion only as it decays: after kSeenThrough decay times none can hide.
  double slowest = fit_.slowest_rate();
  const auto of_chain = chain_.seen_by(fit());
  for (const Complex& pole : of_chain) slowest = std::min(slowest, -pole.real());
  const bool seen = slowest * to_s(now.now_ns - knocks_.free_since_ns()) > kSeenThrough;
  const bool last = seen && !(poles().hums() || matters);
  fit_.allow(std::min(kFitsMeasuring, fit_.affordable(fit().poles().size())));
  search_.best().assign(poles().beside.begin(), poles().beside.end());
  search_.best().insert(search_.best().end(), poles().chain.begin(), poles().chain.end());
  fit_.feed(now.channels);
  fit_.solve(now.channels);
  static_cast<void>(follow_drive(counted, now));
  const double refined = search_.refine(fit().misfit(), 1, now);
  // The verdict may have had too few data for good poles: tries those of the chain as now identified.
  search_.still_there(of_chain, knocks_.free_since_ns(), now, search_.trial());
  if (fit_.may_fit() && !search_.trial().empty())
    if (const double other = search_.try_trial(fit().omega(), refined, now); other < refined)
      search_.refine(other, PoleSearch::kManySteps, now);
  search_.take_best();
  propagate_poles(now);
  begin_measuring(now);
  return last;
}

bool TransientModel::takes_back(std::int64_t verdict_ns, const HoldNow& now) noexcept {
  if (!explained(now)) return false;
  const auto premature = left_.premature(verdict_ns, now);
  if (premature) taken_back_ = premature;
  return premature.has_value();
}

std::optional<std::int64_t> TransientModel::mend(std::int64_t end_ns, const HoldNow& now,
                                                 SettlingDetector::Verdict& verdict) const noexcept {
  left_.tell(end_ns, now, verdict);
  if (!(verdict.worst_left <= 1)) return {};
  return left_.counts_from(end_ns, now);
}

void TransientModel::settle_again(const HoldNow& now) noexcept {
  removal_.stop();
  schedule_.made(now.now_ns);
  plan_growth(kHoldGrowth, now);
}

void TransientModel::remember_modes(const HoldNow& now) noexcept {
  shown_.remember(fit_, noise_, knocks_.free_since_ns(), now);
}

}  // namespace dwell
