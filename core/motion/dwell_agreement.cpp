#include "core/motion/dwell_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/wording.hpp"
#include "core/motion/missing_wording.hpp"
#include "core/motion/pattern_in_noise.hpp"

namespace dwell {
namespace {

// Neither estimate is as efficient as theory has it: of the larger variance this part stands at least.
constexpr double kLeastPart = 0.1;
// How often noise alone may make one of all coefficients contradict: a person is told. Halved or doubled, a difference
// counts from 4 % more or less on.
constexpr double kContradictedByChance = 1e-3;
// U95 beyond which a number is wrong, not inexact: five standard uncertainties. Smaller: of 53 healthy recordings, with
// drop-outs, unfitted harmonics and drives that drift, three differ by 1.1 … 1.6. Larger: wrong numbers go unsaid.
constexpr double kWrong = 2.5;

// Variance of a dwell's coefficient by what its own readings scatter.
double noise_variance(const Coefficient& coefficient, const std::vector<BudgetShare>& budget,
                      double BudgetShare::*share) {
  double part = 0.0;
  for (const BudgetShare& one : budget)
    if (one.kind == SourceKind::noise) part += one.*share;
  return part * coefficient.u * coefficient.u;
}

// Every coefficient that both have, each as if it were the only one.
std::vector<Agreement> differences(const MotionEstimate& motion, const Dwell& dwell) {
  std::vector<Agreement> all;
  const bool inside =
      motion.start_s <= dwell.settled_s && dwell.end_s <= motion.end_s + 0.1 * (motion.end_s - motion.start_s);
  for (std::size_t e = 0; e < std::min(motion.elements.size(), dwell.elements.size()); ++e) {
    const ElementEstimate &ours = motion.elements[e], &other = dwell.elements[e];
    if (!ours.identifiable || !other.identifiable) continue;
    const auto compare = [&](CoefficientKind kind, const Coefficient& a, const Coefficient& b, double u_noise,
                             double BudgetShare::*share) {
      const double va = u_noise * u_noise, vb = noise_variance(b, other.budget, share);
      const double variance = inside ? std::max(std::abs(vb - va), kLeastPart * std::max(va, vb)) : va + vb;
      const double d = std::abs(a.value - b.value);
      all.push_back({ours.k, kind, d / std::hypot(a.U95, b.U95), false, d / (2 * std::sqrt(variance))});
    };
    compare(CoefficientKind::stiffness, ours.stiffness, other.stiffness, motion.u_of_noise[2 * e],
            &BudgetShare::stiffness_share);
    compare(CoefficientKind::damping, ours.damping, other.damping, motion.u_of_noise[2 * e + 1],
            &BudgetShare::damping_share);
  }
  return all;
}

// Channels in which the sampling may fold harmonics of the drive onto the fundamental. The dwell's ± assumes a size of
// these harmonics; the method of any motion needs none.
std::vector<std::string> folding_channels(const Dwell& dwell, const std::vector<int>& elements) {
  std::vector<std::string> names;
  for (const ElementEstimate& element : dwell.elements) {
    if (std::find(elements.begin(), elements.end(), element.k) == elements.end()) continue;
    for (const BudgetShare& one : element.budget)
      if (one.kind == SourceKind::folded_harmonics) names.push_back(one.channel);
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::optional<Objection> contradiction_of(const MotionEstimate& motion, const Dwell& dwell) {
  const std::vector<Agreement> all = differences(motion, dwell);
  Objection out;
  const Agreement* largest = nullptr;
  for (const Agreement& one : all) {
    if (!(one.over_U > kWrong)) continue;
    if (out.elements.empty() || out.elements.back() != one.element) out.elements.push_back(one.element);
    if (largest == nullptr || one.over_U > largest->over_U) largest = &one;
  }
  if (largest == nullptr) return std::nullopt;
  out.what = "any motion: from " + brief(motion.start_s, 4) + " s to " + brief(motion.end_s, 4) + " s the " +
             to_string(largest->kind) + " of element " + std::to_string(largest->element) +
             " differs from this dwell's by " + brief(largest->over_U, 2) +
             " of the joint U of both: the rig, a transducer or a clock may have changed on the way";
  if (const auto names = folding_channels(dwell, out.elements); !names.empty())
    out.what += ", or a harmonic of the drive folds onto the fundamental in " + listed(names);
  return out;
}

// The elements of the dwell with a coefficient that a missing term would move by more than `times` its U95. All terms
// count that explain the readings equally well. nullopt: no term explains the readings, or it is not known what the
// terms would move. One search finds all of them, so that is known of all or of none.
std::optional<std::vector<int>> moved_elements(const MotionEstimate& motion, const Dwell& dwell, double times) {
  const auto unknown = [&](const MissingTerm& term) { return term.moves.size() < 2 * dwell.elements.size(); };
  if (motion.missing.empty() || std::any_of(motion.missing.begin(), motion.missing.end(), unknown)) return std::nullopt;
  std::vector<int> moved;
  for (std::size_t e = 0; e < dwell.elements.size(); ++e) {
    const ElementEstimate& element = dwell.elements[e];
    const auto moves = [&](const MissingTerm& term) {
      return std::abs(term.moves[2 * e]) > times * element.stiffness.U95 ||
             std::abs(term.moves[2 * e + 1]) > times * element.damping.U95;
    };
    if (element.identifiable && std::any_of(motion.missing.begin(), motion.missing.end(), moves))
      moved.push_back(element.k);
  }
  return moved;
}

// The chain is not refused, but terms are named that explain the readings better.
std::optional<Objection> better_explained(const MotionEstimate& motion, const Dwell& dwell) {
  const auto moved = moved_elements(motion, dwell, 1.0), wrong = moved_elements(motion, dwell, kWrong);
  if (!moved || moved->empty()) return std::nullopt;
  const std::string with = told_together(motion.missing), gain = brief(motion.missing.front().gain);
  const std::string moves = elements_text(*moved) + " by more than U95";
  return Objection{
      "any motion: the readings are better explained with " + with +
          (motion.missing.size() == 1 ? " (gain " + gain + "), which would move " + moves
                                      : " (gain " + gain + " of the first): one or the other may move " + moves),
      !wrong->empty(), *moved};
}

// The dwell's ± takes all scatter of its readings for noise, which averages out. A pattern may not.
std::optional<Objection> with_patterns(std::optional<Objection> objection, const MotionEstimate& motion) {
  if (motion.patterns.empty()) return objection;
  const char* before = objection ? "; " : ": ";
  Objection out = objection ? std::move(*objection) : Objection{"any motion", false, {}};
  if (!out.grave) out.elements.clear();  // the pattern concerns all; a grave objection doubts its own alone
  for (const ReadingsPattern& pattern : motion.patterns)
    out.what += std::exchange(before, "; ") + words_of_pattern(pattern);
  out.what += ". The ± of this dwell does not cover it";
  return out;
}

}  // namespace

std::optional<Objection> objection_to(const Dwell& dwell, const MotionEstimate& motion) {
  // A rig file is wrong all the time or never. So any part of the hold may tell of a term that it lacks.
  const bool of_its_hold = dwell.start_s < motion.end_s && motion.start_s < dwell.end_s;
  if (!of_its_hold) return std::nullopt;
  const bool of_its_data = dwell.settled_s < motion.end_s;
  if (!motion.contradicted) {
    std::optional<Objection> objection = contradiction_of(motion, dwell);
    if (!objection) objection = better_explained(motion, dwell);
    return of_its_data && motion.reason.empty() ? with_patterns(std::move(objection), motion) : objection;
  }
  if (!of_its_data) return std::nullopt;
  const auto moved = moved_elements(motion, dwell, 1.0);
  return Objection{"any motion: " + motion.reason, !moved || !moved->empty(), {}};
}

bool may_object(const Dwell& dwell, const MotionEstimate& motion) noexcept {
  const bool says_something = !motion.elements.empty() || motion.contradicted;
  return says_something && dwell.index && std::isfinite(dwell.settled_s);
}

std::optional<Agreement> agreement_of(const MotionEstimate& motion, const Dwell& dwell) {
  std::vector<Agreement> all = differences(motion, dwell);
  if (all.empty()) return std::nullopt;
  for (Agreement& one : all) {
    const double by_chance = static_cast<double>(all.size()) * std::erfc(std::sqrt(2.0) * one.e_n);
    one.contradicts = one.over_U > 1 && by_chance < kContradictedByChance;
  }
  Agreement named = *std::max_element(all.begin(), all.end(), [](const Agreement& a, const Agreement& b) {
    return std::pair(a.contradicts, a.over_U) < std::pair(b.contradicts, b.over_U);
  });
  for (const Agreement& one : all) named.e_n = std::max(named.e_n, one.e_n);
  return named;
}

}  // namespace dwell
