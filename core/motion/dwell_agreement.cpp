#include "core/motion/dwell_agreement.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

// Neither estimate is as efficient as theory has it: of the larger variance this part stands at least.
constexpr double kLeastPart = 0.1;

// Variance of a dwell's coefficient by what its own readings scatter.
double noise_variance(const Coefficient& coefficient, const std::vector<BudgetShare>& budget,
                      double BudgetShare::*share) {
  double part = 0.0;
  for (const BudgetShare& one : budget)
    if (one.source.rfind("noise of ", 0) == 0) part += one.*share;
  return part * coefficient.u * coefficient.u;
}

}  // namespace

double agreement_e_n(const MotionEstimate& motion, const Dwell& dwell) {
  double largest = kNaN;
  const bool inside =
      motion.start_s <= dwell.settled_s && dwell.end_s <= motion.end_s + 0.1 * (motion.end_s - motion.start_s);
  for (std::size_t e = 0; e < std::min(motion.elements.size(), dwell.elements.size()); ++e) {
    const ElementEstimate &ours = motion.elements[e], &other = dwell.elements[e];
    if (!ours.identifiable || !other.identifiable) continue;
    const auto compare = [&](const Coefficient& a, const Coefficient& b, double u_noise, double BudgetShare::*share) {
      const double va = u_noise * u_noise, vb = noise_variance(b, other.budget, share);
      const double variance = inside ? std::max(std::abs(vb - va), kLeastPart * std::max(va, vb)) : va + vb;
      const double e_n = std::abs(a.value - b.value) / (2 * std::sqrt(variance));
      largest = std::isnan(largest) ? e_n : std::max(largest, e_n);
    };
    compare(ours.stiffness, other.stiffness, motion.u_of_noise[2 * e], &BudgetShare::stiffness_share);
    compare(ours.damping, other.damping, motion.u_of_noise[2 * e + 1], &BudgetShare::damping_share);
  }
  return largest;
}

}  // namespace dwell
