#include "core/motion/dwell_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/wording.hpp"

namespace dwell {
namespace {

// Neither estimate is as efficient as theory has it: of the larger variance this part stands at least.
constexpr double kLeastPart = 0.1;
// How often noise alone may make one of all coefficients contradict.
constexpr double kByChance = 0.05;
// … and how often it may make a healthy dwell doubted. Halved: real changes of 3 u go unseen a little more often. Doubled: a
// healthy recording in 500 is doubted.
constexpr double kDoubtedByChance = 1e-3;

// Variance of a dwell's coefficient by what its own readings scatter.
double noise_variance(const Coefficient& coefficient, const std::vector<BudgetShare>& budget,
                      double BudgetShare::*share) {
  double part = 0.0;
  for (const BudgetShare& one : budget)
    if (one.source.rfind("noise of ", 0) == 0) part += one.*share;
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

// How often noise alone makes one of so many coefficients differ by so much, at most (Bonferroni).
double chance_of(const Agreement& one, std::size_t coefficients) {
  return static_cast<double>(coefficients) * std::erfc(std::sqrt(2.0) * one.e_n);
}

std::optional<Objection> contradiction_of(const MotionEstimate& motion, const Dwell& dwell) {
  const std::vector<Agreement> all = differences(motion, dwell);
  Objection out;
  const Agreement* largest = nullptr;
  for (const Agreement& one : all) {
    if (!(one.over_U > 1 && chance_of(one, all.size()) < kDoubtedByChance)) continue;
    if (out.elements.empty() || out.elements.back() != one.element) out.elements.push_back(one.element);
    if (largest == nullptr || one.over_U > largest->over_U) largest = &one;
  }
  if (largest == nullptr) return std::nullopt;
  out.what = "any motion: from " + brief(motion.start_s, 4) + " s to " + brief(motion.end_s, 4) + " s the " +
             to_string(largest->kind) + " of element " + std::to_string(largest->element) +
             " differs from this dwell's by " + brief(largest->over_U, 2) +
             " of the joint U of both: the rig, a transducer or a clock may have changed on the way";
  return out;
}

// Whether the term that explains the readings leaves every coefficient of the dwell within its U95. Not where nothing
// explains them, or what the term moves is not known.
bool moves_little(const MotionEstimate& motion, const Dwell& dwell) {
  if (motion.missing.empty() || motion.missing.front().moves.size() < 2 * dwell.elements.size()) return false;
  const std::vector<double>& moves = motion.missing.front().moves;
  for (std::size_t e = 0; e < dwell.elements.size(); ++e) {
    const ElementEstimate& element = dwell.elements[e];
    if (!element.identifiable) continue;
    const bool little =
        std::abs(moves[2 * e]) <= element.stiffness.U95 && std::abs(moves[2 * e + 1]) <= element.damping.U95;
    if (!little) return false;
  }
  return true;
}

}  // namespace

std::optional<Objection> objection_to(const Dwell& dwell, const MotionEstimate& motion) {
  const bool inside = dwell.settled_s < motion.end_s && motion.start_s < dwell.end_s;
  if (!inside) return std::nullopt;
  if (!motion.contradicted) return contradiction_of(motion, dwell);
  return Objection{"any motion: " + motion.reason, !moves_little(motion, dwell), {}};
}

std::optional<Agreement> agreement_of(const MotionEstimate& motion, const Dwell& dwell) {
  std::vector<Agreement> all = differences(motion, dwell);
  if (all.empty()) return std::nullopt;
  for (Agreement& one : all) {
    one.contradicts = one.over_U > 1 && chance_of(one, all.size()) < kByChance;
  }
  Agreement named = *std::max_element(all.begin(), all.end(), [](const Agreement& a, const Agreement& b) {
    return std::pair(a.contradicts, a.over_U) < std::pair(b.contradicts, b.over_U);
  });
  for (const Agreement& one : all) named.e_n = std::max(named.e_n, one.e_n);
  return named;
}

}  // namespace dwell
