#include "core/transient/hold_refit.hpp"

#include <algorithm>

#include "core/base/complex.hpp"
#include "core/transient/fit_limits.hpp"
#include "core/transient/hold_now.hpp"

namespace dwell {
namespace {

// Parts of the hold that are skipped at its beginning: modes that have decayed by then need not be fitted. Each fit
// that does not explain the data skips kSkippedMore further, up to kSkippedMost.
constexpr double kSkipped = 0.15, kSkippedMore = 0.1, kSkippedMost = 0.6;
constexpr int kHoldRefinements =
    2;  // refinement steps for poles believed so far and at each begin after a knock, at most
constexpr double kPenalty = 50.0;  // added to the misfit for each pole beside the chain's

bool any_near(std::span<const Complex> poles, Complex pole) {
  return std::any_of(poles.begin(), poles.end(),
                     [&](Complex other) { return std::abs(pole - other) < kSamePole * std::abs(pole); });
}

}  // namespace

HoldRefit::HoldRefit(const Parts& parts, std::size_t masses) : parts_(parts) {
  for (std::vector<Complex>* poles : {&kept_.poles, &kept_.beside, &beside_before_, &known_})
    poles->reserve(4 * masses + 4);
}

bool HoldRefit::possible() const noexcept {
  return !parts_.search.poles().chain.empty() || !parts_.chain.last().empty();
}

bool HoldRefit::make(const SeenFrequency& seen, const HoldNow& now) {
  if (!possible()) return false;
  auto& [chain, fit, noise, knocks, search, lines] = parts_;
  PoleSet& poles = search.poles();
  place_begin(now);
  fit.measure_ranges(now.channels);
  // Starts from the ω of the hold's last fit, of all channels, unless ω is given or drifts; else from the table's own.
  const bool fitted = fit.fit().usable(now.drive_channel) && fit.fit().t0_ns() >= now.steady_ns;
  const bool drifts = seen.rate != 0 || fit.fit().rate() != 0;
  const double w = seen.at(fit.from_ns());
  const double first_w = fitted && !now.omega_given && !drifts ? fit.fit().omega() : w;
  fit.set_rate(seen.rate);
  // A hold's first refit has no poles of its own. It starts from the poles of the chain that was identified last, from
  // the mean of the windows.
  if (poles.chain.empty()) poles.chain.assign(chain.last().begin(), chain.last().end());
  beside_before_ = poles.beside;
  kept_.misfit = INFINITY;
  kept_.poles.clear();
  fit.allow(fit.affordable(poles.chain.size() + ForeignLines::kMost));
  for (const Source source : {Source::believed, Source::chain, Source::chain_alone, Source::latest_third}) {
    const bool first = source == Source::believed;
    if (!first && !fit.may_fit()) break;
    if (!set_up(source, fitted, w, now)) continue;
    const double misfit = search.refine(search.fit_best(first ? first_w : w, now),
                                        first ? kHoldRefinements : PoleSearch::kManySteps, now);
    if (keep_if_better(misfit) && explained(now)) break;
    // No poles explain the motion on both sides of a knock.
    if (first && (knocks.any() || skipped_ >= kSkippedMost) && !explained(now) && explain_since_knock(w, now)) {
      search.take_best();
      skipped_ = 0.0;
      return true;
    }
  }
  if (!(kept_.misfit < INFINITY)) return false;
  finish(now);
  return true;
}

void HoldRefit::place_begin(const HoldNow& now) noexcept {
  const SampleHistory& history = parts_.fit.history();
  const std::int64_t free_ns = parts_.knocks.free_since_ns();
  // The first period may hold the end of the motion before.
  const std::int64_t skipped_ns = std::max(
      to_ns(kUnsure * now.period_s()), static_cast<std::int64_t>(skipped_ * static_cast<double>(now.now_ns - free_ns)));
  parts_.fit.begin_at(std::max(free_ns + skipped_ns, history[history.begin()].t_ns));
}

// omega: of the drive where the fit begins.
bool HoldRefit::set_up(Source source, bool fitted, double omega, const HoldNow& now) {
  auto& [chain, fit, noise, knocks, search, lines] = parts_;
  PoleSet& poles = search.poles();
  poles.beside.clear();
  if (source == Source::believed || source == Source::chain) poles.beside = beside_before_;
  if (source == Source::latest_third) {
    const std::int64_t from_ns = fit.from_ns();
    fit.begin_at(std::max(from_ns, now.now_ns - (now.now_ns - knocks.free_since_ns()) / 3));
    fit.anew(omega + fit.rate() * to_s(fit.from_ns() - from_ns), {}, now.channels);
    fit.begin_at(from_ns);
  }
  if (source == Source::believed && fitted) renew_silent_poles();
  const std::span<const Complex> from =
      source == Source::believed ? std::span<const Complex>(poles.chain) : chain.seen_by(fit.fit());
  if (from.empty()) return false;
  search.still_there(from, knocks.free_since_ns(), now, search.best());
  return true;
}

bool HoldRefit::keep_if_better(double misfit) {
  const std::vector<Complex>& beside = parts_.search.poles().beside;
  const double penalized = misfit + kPenalty * static_cast<double>(beside.size());
  if (!(penalized < kept_.misfit)) return false;
  kept_.misfit = penalized;
  kept_.poles = parts_.search.best();
  kept_.omega = parts_.fit.fit().omega();
  kept_.beside = beside;
  return true;
}

// Replaces the poles that show in no channel by those of the chain as now identified: only the chain tells them.
void HoldRefit::renew_silent_poles() {
  auto& [chain, fit, noise, knocks, search, lines] = parts_;
  std::vector<Complex>&believed = search.poles().chain, &renewed = search.trial();
  const std::size_t beside = search.poles().beside.size();
  if (fit.fit().poles().size() < beside + believed.size()) return;
  const auto identified = chain.seen_by(fit.fit());
  renewed.clear();
  for (std::size_t m = 0; m < believed.size(); ++m)
    if (fit.fit().shows(beside + m)) renewed.push_back(believed[m]);
  for (const Complex& pole : identified) {
    if (renewed.size() == believed.size()) break;
    if (!any_near(renewed, pole)) renewed.push_back(pole);
  }
  if (!identified.empty()) believed = renewed;
}

bool HoldRefit::explain_since_knock(double omega, const HoldNow& now) {
  auto& [chain, fit, noise, knocks, search, lines] = parts_;
  std::vector<Complex>& beside = search.poles().beside;
  const std::int64_t from_ns = fit.from_ns();
  const std::int64_t first_ns =
      knocks.alarmed_since(from_ns) ? *knocks.alarm_ns() : from_ns + (now.now_ns - from_ns) / 2;
  if (fit_since_knock(omega, first_ns, now)) return true;
  if (beside.empty()) return false;
  // A knock within the fit looks like decaying lines beside the chain: tries without these.
  std::erase_if(beside, [](Complex pole) { return pole.real() < 0; });
  if (fit_since_knock(omega, first_ns, now)) return true;
  beside = beside_before_;
  return false;
}

// Fits the free motion since the last knock by itself, with the poles known. Of ever later begins it takes the earliest
// from which on they explain the data. false: there is none yet.
bool HoldRefit::fit_since_knock(double omega, std::int64_t first_ns, const HoldNow& now) {
  auto& [chain, fit, noise, knocks, search, lines] = parts_;
  const std::int64_t was_from_ns = fit.from_ns();
  const auto least_ns = to_ns(kPeriodsToTell * now.period_s());
  known_.assign(search.poles().chain.begin(), search.poles().chain.end());
  for (const Complex& pole : chain.last())
    if (!any_near(known_, pole)) known_.push_back(pole);
  for (std::int64_t length_ns = now.now_ns - first_ns; length_ns >= least_ns && fit.may_fit(); length_ns /= 2) {
    fit.begin_at(now.now_ns - length_ns);
    const std::int64_t free_before_ns = knocks.free_since_ns();
    knocks.set_free_since(fit.from_ns());
    search.still_there(known_, fit.from_ns(), now, search.best());
    const double w = omega + fit.rate() * to_s(fit.from_ns() - was_from_ns);
    search.refine(search.fit_best(w, now), kHoldRefinements, now);
    if (fit.determined() && explained(now)) return true;
    knocks.set_free_since(free_before_ns);
  }
  fit.begin_at(was_from_ns);
  return false;
}

// Restores the best fit. Adds a line beside the chain where the residuals show one.
void HoldRefit::finish(const HoldNow& now) {
  auto& [chain, fit, noise, knocks, search, lines] = parts_;
  std::vector<Complex>&best = search.best(), &beside = search.poles().beside;
  if (best != kept_.poles || fit.fit().omega() != kept_.omega) {
    fit.anew(kept_.omega, kept_.poles, now.channels);
    noise.compare_halves(fit, now.now_ns);
  }
  best = kept_.poles;
  beside = kept_.beside;
  if (!knocks.any() && fit.may_fit() && lines.find(now)) {
    std::rotate(beside.begin(), beside.end() - 1, beside.end());
    best.insert(best.begin(), beside.front());
    search.refine(search.fit_best(kept_.omega, now), PoleSearch::kManySteps, now);
  }
  search.take_best();
  lines.judge(now);
  // Where the data are not explained the next fit begins later: less of the unexplained motion is left there.
  skipped_ = explained(now) ? kSkipped : std::min(skipped_ + kSkippedMore, kSkippedMost);
}

}  // namespace dwell
