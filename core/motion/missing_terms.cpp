#include "core/motion/missing_terms.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/motion/candidates.hpp"
#include "core/motion/inflated_process.hpp"
#include "core/motion/missing_wording.hpp"
#include "core/motion/refit.hpp"
#include "core/motion/rig_mistakes.hpp"
#include "core/motion/score_test.hpp"
#include "core/motion/unchecked.hpp"
#include "core/motion/whiteness.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;

// False-alarm probability of a healthy rig, over all candidates: 0.05 false names in 500 rigs. With 30 candidates a
// gain of 11 is needed, a term of 4.7 standard uncertainties. A tenth of this probability needs 13.
constexpr double kWrongAdvice = 1e-4;
// Effects correlated more than this are one effect to these readings: named together.
constexpr double kSameEffect = 0.95;
// Two explanations whose gains differ by less are not told apart: odds of 150 to 1.
constexpr double kTold = 5.0;
// The score test is linear and misjudges the gain of a large fault. So every candidate above this part of the best gain
// is fitted, at most kMostFitted with different effects.
constexpr double kWorthFitting = 0.2;
// Beside a fit that has failed any other looks good. So a fit from the start explains the readings only if its chain
// would not be refused, or if its residuals are a tenth as large.
constexpr double kNearly = 0.01;
// Standard deviations by which a term may move when the process noise is inflated: chance moves one right term in 400
// further.
constexpr double kMovedByChance = 3.0;
constexpr std::size_t kMostFitted = 4, kMostNamed = 6;
// Readings on which all hypotheses are tried first.
constexpr std::size_t kScreened = 1500;
// Screening ends after kMostTries times the work of the estimate itself. That work counts as at least two hundred
// passes over kScreened readings: some seconds, enough for forty hypotheses of fifty passes each. A hypothesis that was
// not tried by then is not named. Those close to the best are then fitted to all readings, and at most kMostNamed
// named.
constexpr double kMostTries = 10.0, kLeastTried = 200.0 * kScreened;

double work_of(const MotionCourse& course) {
  return static_cast<double>(course.passes) * static_cast<double>(course.data.readings.size());
}

// 2 gain of a candidate without effect is χ² of one degree of freedom: P(gain > g) = erfc(√g).
double gain_by_chance(std::size_t candidates) {
  const double chance = kWrongAdvice / static_cast<double>(std::max<std::size_t>(1, candidates));
  double low = 0.0, high = 100.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (std::erfc(std::sqrt(middle)) > chance ? low : high) = middle;
  }
  return high;
}

struct Explanation {
  std::vector<MissingTerm> terms;
  Leftover left;
  double of_table = 0.0;  // by which V fell by another process of the table; the terms are beside that
  [[nodiscard]] double gain() const { return of_table + (terms.empty() ? 0.0 : terms.front().gain); }
};

void sort_by_gain(std::vector<MissingTerm>& terms) {
  std::stable_sort(terms.begin(), terms.end(),
                   [](const MissingTerm& a, const MissingTerm& b) { return a.gain > b.gain; });
}

// One physical term at a time, about the fit.
class TermSearch {
 public:
  TermSearch(const Rig& rig, const MotionCourse& course)
      : rig_(rig), course_(course), test_(score_test(rig, course)), limit_(gain_by_chance(test_.candidates.size())) {}

  [[nodiscard]] std::vector<std::string> not_checked() const { return unchecked(rig_, test_); }

  [[nodiscard]] Explanation run(const Leftover& before) const {
    const std::vector<Index> likely = likeliest();
    std::vector<Index> fitted;
    Index best = -1;
    Refit best_fit;
    for (const Index a : likely) {
      if (fitted.size() == kMostFitted) break;
      if (std::any_of(fitted.begin(), fitted.end(), [&](Index b) { return test_.correlation(a, b) > kSameEffect; }))
        continue;
      fitted.push_back(a);
      const Refit fit = refit(a);
      if (!fit.converged || !is_possible(rig_, candidate(a), fit.value) || !fit.left.explains_most_of(before)) continue;
      if (evidence(a, fit) < limit_ || (best >= 0 && fit.gain <= best_fit.gain)) continue;
      best = a;
      best_fit = fit;
    }
    if (best < 0 || !stands_with_inflated_noise(best, best_fit)) return {};
    return named(best, best_fit, likely);
  }

 private:
  [[nodiscard]] Refit refit(Index a) const {
    return refit_with(rig_, course_, candidate(a), test_.maximum_with(a, course_.fit.at), test_.value(a));
  }
  // The smaller of the drop of V and ½ (value/u)². If the fit without the term had not reached its maximum, V would
  // drop with any term.
  [[nodiscard]] double evidence(Index a, const Refit& fit) const {
    double variance = fit.u * fit.u;
    for (const Parameter& p : course_.parameters)
      if (p.what == candidate(a).what && p.index == candidate(a).index) variance += p.prior_u * p.prior_u;
    return std::min(fit.gain, 0.5 * fit.value * fit.value / variance);
  }
  [[nodiscard]] const Parameter& candidate(Index a) const { return test_.candidates[static_cast<std::size_t>(a)]; }

  // Candidates with a gain beyond chance, likeliest first. Those whose expected sign is impossible are left out: the
  // score test foretells the sign of large effects as well.
  [[nodiscard]] std::vector<Index> likeliest() const {
    std::vector<Index> out;
    double most = 0.0;
    for (Index a = 0; a < test_.score.size(); ++a) {
      if (!test_.told[static_cast<std::size_t>(a)] || test_.gain(a) < limit_) continue;
      if (!is_possible(rig_, candidate(a), std::copysign(1e-9 * test_.sizes(a), test_.value(a)))) continue;
      out.push_back(a);
      most = std::max(most, test_.gain(a));
    }
    std::stable_sort(out.begin(), out.end(), [&](Index a, Index b) { return test_.gain(a) > test_.gain(b); });
    std::erase_if(out, [&](Index a) { return test_.gain(a) < kWorthFitting * most; });
    return out;
  }

  [[nodiscard]] MissingTerm told(Index a, const Refit& fit) const {
    MissingTerm out = missing_term(rig_, candidate(a), fit.value, fit.u, fit.gain);
    out.moves.assign(fit.moves.begin(), fit.moves.end());
    return out;
  }
  // A term moves when the process noise of the table is inflated. What of that is beyond chance is an error of the
  // process. The term must still be beyond chance with this error as a part of its u. If the inflated fit comes to no
  // end, nothing is known of such an error.
  [[nodiscard]] bool stands_with_inflated_noise(Index a, const Refit& fit) const {
    const MotionCourse inflated = with_inflated_process_noise(rig_, course_);
    if (!inflated.fit.converged) return true;
    const Refit other = refit_with(rig_, inflated, candidate(a), inflated.fit.at, fit.value);
    if (!other.converged) return true;
    const double by_chance = kMovedByChance * std::sqrt(std::max(0.0, other.u * other.u - fit.u * fit.u));
    Refit with_error = fit;
    with_error.u = std::hypot(fit.u, std::max(0.0, std::abs(other.value - fit.value) - by_chance));
    return evidence(a, with_error) >= limit_;
  }
  // The best and all that have the same effect.
  [[nodiscard]] Explanation named(Index best, const Refit& fit, const std::vector<Index>& likely) const {
    Explanation out{{told(best, fit)}, fit.left};
    for (const Index a : likely) {
      if (a == best || test_.correlation(a, best) <= kSameEffect || out.terms.size() == kMostNamed) continue;
      const Refit other = refit(a);
      if (!other.converged || !is_possible(rig_, candidate(a), other.value)) continue;
      out.terms.push_back(told(a, other));
    }
    sort_by_gain(out.terms);
    return out;
  }

  const Rig& rig_;
  const MotionCourse& course_;
  ScoreTest test_;
  double limit_;
};

// What may be wrong where the fit has gone astray: a mistake of the rig file, or a large error of one term.
struct Hypothesis {
  RigMistake mistake;
  std::optional<Parameter> term;  // in place of a mistake
};

// Hypotheses, each with the chain fitted anew from its start: first on few readings, the best on all.
class FitsAnew {
 public:
  // tried: what the estimate took to be made, in readings times passes.
  FitsAnew(const Rig& rig, const MotionData& data, std::size_t most, double tried, std::stop_token stop)
      : rig_(rig), data_(data), most_(most), stop_(std::move(stop)), left_(kMostTries * std::max(tried, kLeastTried)) {
    for (const RigMistake& mistake : rig_mistakes(rig)) all_.push_back({mistake, {}});
    for (const Parameter& term : missing_candidates(rig))
      if (!is_input(term.what)) all_.push_back({{}, term});
  }

  [[nodiscard]] Explanation run(const ChainFit& before) {
    const std::size_t few = std::min(most_, kScreened);
    const ChainFit now = chain_fit(rig_, run_course(rig_, data_, few, {}, stop_));
    std::vector<std::pair<double, const Hypothesis*>> likely;
    for (const Hypothesis& one : all_) {
      if (!(left_ > 0.0)) {
        ++untried_;
        continue;
      }
      if (const Tried tried = fitted(one, few); tried.fit.possible) likely.emplace_back(gain(now, tried.fit), &one);
    }
    std::stable_sort(likely.begin(), likely.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    Explanation out;
    for (const auto& [screened, one] : likely) {
      if (!as_good(*one, screened, likely.front().first) || out.terms.size() == kMostNamed) break;
      const Tried tried = fitted(*one, most_);
      const double gained = gain(before, tried.fit);
      if (!tried.fit.possible || !explains(before, tried.fit, gained) || !matters(*one, tried)) continue;
      if (gained > out.gain()) out.left = tried.fit.left;
      out.terms.push_back(told(*one, tried, gained));
      sort_by_gain(out.terms);
    }
    if (!out.terms.empty()) {
      const double best = out.gain();
      std::erase_if(out.terms, [&](const MissingTerm& term) {
        return !as_good(std::isfinite(term.value) ? kAnyTerm : kAnyMistake, term.gain, best);
      });
    }
    return out;
  }

  [[nodiscard]] std::size_t untried() const noexcept { return untried_; }

 private:
  struct Tried {
    ChainFit fit;
    double value = 0.0, u = 0.0;  // of a term
  };
  [[nodiscard]] Tried fitted(const Hypothesis& one, std::size_t most) {
    if (!one.term) return {fit_of(run_course(rig_, without(rig_, data_, one.mistake), most, {}, stop_))};
    Tried out = with_term(*one.term, data_, most);
    // The model's delay is a series, exact for small delays only. So the stamps are shifted by the delay found first,
    // and a second fit finds the rest.
    if (one.term->what == Unknown::delay && most == most_ && out.fit.possible) {
      const double before = out.value;
      out = with_term(*one.term, shifted(data_, one.term->index, -before), most);
      out.value += before;
    }
    out.fit.possible = out.fit.possible && is_possible(rig_, *one.term, out.value);
    return out;
  }
  [[nodiscard]] ChainFit fit_of(const MotionCourse& course) {
    left_ -= work_of(course);
    return chain_fit(rig_, course);
  }
  [[nodiscard]] Tried with_term(const Parameter& term, const MotionData& data, std::size_t most) {
    const MotionCourse course = run_course(rig_, data, most, term, stop_);
    Tried out{fit_of(course)};
    if (!out.fit.possible) return out;
    for (std::size_t a = 0; a < course.parameters.size(); ++a)
      if (course.parameters[a].what == term.what && course.parameters[a].index == term.index) {
        out.value = course.fit.at.theta(static_cast<Index>(a));
        out.u = std::sqrt(course.fit.covariance(static_cast<Index>(a), static_cast<Index>(a)));
      }
    return out;
  }
  [[nodiscard]] MissingTerm told(const Hypothesis& one, const Tried& tried, double gained) const {
    if (one.term) return missing_term(rig_, *one.term, tried.value, tried.u, gained);
    MissingTerm term;
    term.what = name_of(rig_, one.mistake);
    term.told = in_words(rig_, one.mistake);
    term.gain = gained;
    return term;
  }
  // Whether it may be named beside the best. A term whose effect is correlated by ρ with the true one has ρ² of its
  // gain.
  [[nodiscard]] static bool as_good(const Hypothesis& one, double gain, double best) {
    return gain >= best - kTold || (one.term && gain >= kSameEffect * kSameEffect * best);
  }
  [[nodiscard]] bool explains(const ChainFit& before, const ChainFit& after, double gained) const {
    const bool nearly = after.left.least_p >= kContradicted || after.left.power <= kNearly * before.left.power;
    if (gained > gain_by_chance(all_.size()) && after.left.explains_most_of(before.left) && nearly) return true;
    // If the first fit was impossible (a negative coefficient), a possible one that is not refused is enough.
    return !before.possible && after.left.least_p >= kContradicted && gained > -kTold;
  }
  // A fit begun anew may find what the fit before missed, whatever is added: a term must be beyond chance by its value.
  [[nodiscard]] bool matters(const Hypothesis& one, const Tried& tried) const {
    if (!one.term) return true;
    double variance = tried.u * tried.u;
    for (const Parameter& p : stated_parameters(rig_))
      if (p.what == one.term->what && p.index == one.term->index) variance += p.prior_u * p.prior_u;
    return 0.5 * tried.value * tried.value / variance > gain_by_chance(all_.size());
  }
  // Without a first fit there is no V to compare with: the number of readings then puts them in order, no more.
  [[nodiscard]] static double gain(const ChainFit& before, const ChainFit& after) {
    if (before.readings == 0.0) return after.readings;
    return std::min(before.readings, after.readings) * (before.per_reading - after.per_reading);
  }

  inline static const Hypothesis kAnyTerm{{}, Parameter{}}, kAnyMistake{};
  const Rig& rig_;
  const MotionData& data_;
  std::size_t most_;
  std::stop_token stop_;
  double left_;  // readings times passes that may still be spent
  std::size_t untried_ = 0;
  std::vector<Hypothesis> all_;
};

// Whether some channel behind the table has more noise than the rounding of numbers.
bool has_noise(const Rig& rig, const MotionCourse& course) {
  for (std::size_t a = 0; a < course.parameters.size(); ++a) {
    const Parameter& p = course.parameters[a];
    const auto c = static_cast<std::size_t>(p.index);
    if (p.what == Unknown::noise && !shows_drive(rig.channels[c]) &&
        std::exp(course.fit.at.theta(static_cast<Index>(a))) > kDigits * course.size[c])
      return true;
  }
  return false;
}

// A wandering table does not foresee a swell, and terms of the chain that make up for it have a gain. So the readings
// are fitted with a swelling table. If that alone explains more than the term, terms are sought anew beside it; none
// may be left.
Explanation checked_against_swell(Explanation best, const Rig& rig, const MotionData& data, const MotionCourse& course,
                                  std::size_t most) {
  const MotionCourse swelling = run_course(rig, data, most, {}, course.limits.stop, TableProcess::swelling);
  if (!swelling.reason.empty()) return best;
  const ChainFit before = chain_fit(rig, course), after = chain_fit(rig, swelling);
  const double gained = std::min(before.readings, after.readings) * (before.per_reading - after.per_reading);
  if (!after.possible || !(gained > best.gain())) return best;
  Explanation out = TermSearch(rig, swelling).run(after.left);
  if (out.terms.empty()) out.left = after.left;
  out.of_table = gained;
  return out;
}

}  // namespace

MissingTerms find_missing(const Rig& rig, const MotionData& data, const MotionCourse& course, bool contradicted,
                          std::size_t most, bool anew) {
  const bool refused = contradicted;
  MissingTerms out;
  const ChainFit now = chain_fit(rig, course);
  const bool converged = course.reason.empty() && now.readings > 0;
  Explanation best;
  if (converged) {
    const TermSearch search(rig, course);
    out.unchecked = search.not_checked();
    out.tried_inputs = has_noise(rig, course);
    if (out.tried_inputs) best = search.run(now.left);
    if (!best.terms.empty()) best = checked_against_swell(std::move(best), rig, data, course, most);
    contradicted = contradicted || has_impossible_coefficient(rig, course.fit);
  }
  if (contradicted && (best.terms.empty() || best.left.least_p < kNotWhite || !now.possible)) {
    out.anew = anew ? AnewSearch::done : AnewSearch::put_off;
    if (!anew) {
      if (refused) best = {};  // what was not tried may explain it better
    } else {
      FitsAnew search(rig, data, most, work_of(course), course.limits.stop);
      Explanation other = search.run(now);
      out.untried = search.untried();
      if (!other.terms.empty() && other.gain() > best.gain() - kTold) best = std::move(other);
    }
  }
  out.terms = std::move(best.terms);
  if (now.readings == 0.0)
    for (MissingTerm& term : out.terms) term.gain = kNaN;
  for (MissingTerm& term : out.terms)
    for (const MissingTerm& other : out.terms)
      if (&other != &term) term.or_else.push_back(other.what);
  return out;
}

}  // namespace dwell
