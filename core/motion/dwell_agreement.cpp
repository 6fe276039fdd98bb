#include "core/motion/dwell_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace dwell {
namespace {

// Neither estimate is as efficient as theory has it: of the larger variance this part stands at least.
constexpr double kLeastPart = 0.1;
// That noise alone makes one of all differences so large that both are said to contradict each other.
constexpr double kByChance = 0.05;

// Variance of a dwell's coefficient by what its own readings scatter.
double noise_variance(const Coefficient& coefficient, const std::vector<BudgetShare>& budget,
                      double BudgetShare::*share) {
  double part = 0.0;
  for (const BudgetShare& one : budget)
    if (one.source.rfind("noise of ", 0) == 0) part += one.*share;
  return part * coefficient.u * coefficient.u;
}

struct Difference {
  int element;
  bool damping;
  double e_n, over_U;
};

std::vector<Difference> differences(const MotionEstimate& motion, const Dwell& dwell) {
  std::vector<Difference> all;
  const bool inside =
      motion.start_s <= dwell.settled_s && dwell.end_s <= motion.end_s + 0.1 * (motion.end_s - motion.start_s);
  for (std::size_t e = 0; e < std::min(motion.elements.size(), dwell.elements.size()); ++e) {
    const ElementEstimate &ours = motion.elements[e], &other = dwell.elements[e];
    if (!ours.identifiable || !other.identifiable) continue;
    for (const bool damping : {false, true}) {
      const auto which = damping ? &ElementEstimate::damping : &ElementEstimate::stiffness;
      const auto share = damping ? &BudgetShare::damping_share : &BudgetShare::stiffness_share;
      const Coefficient &a = ours.*which, &b = other.*which;
      const double u_noise = motion.u_of_noise[2 * e + damping], va = u_noise * u_noise,
                   vb = noise_variance(b, other.budget, share),
                   variance = inside ? std::max(std::abs(vb - va), kLeastPart * std::max(va, vb)) : va + vb,
                   d = std::abs(a.value - b.value);
      all.push_back({ours.k, damping, d / (2 * std::sqrt(variance)), d / std::hypot(a.U95, b.U95)});
    }
  }
  return all;
}

}  // namespace

Agreement agreement_of(const MotionEstimate& motion, const Dwell& dwell) {
  Agreement found;
  const std::vector<Difference> all = differences(motion, dwell);
  for (const Difference& d : all) {
    found.e_n = std::fmax(found.e_n, d.e_n);
    // Bonferroni, over all that is compared.
    const bool differs =
        d.over_U > 1 && static_cast<double>(all.size()) * std::erfc(std::sqrt(2.0) * d.e_n) < kByChance;
    if (found.element != 0 && std::tuple(differs, d.over_U) <= std::tuple(found.differ, found.over_U)) continue;
    found.differ = differs;
    found.element = d.element;
    found.damping = d.damping;
    found.over_U = d.over_U;
  }
  return found;
}

}  // namespace dwell
