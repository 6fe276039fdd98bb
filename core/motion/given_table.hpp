// Innovations of the channels behind the table, given all that is read of the table, before and after:
//
//   p(chain | table) = Π p(reading i | readings of the chain before i, all readings of the table)
//
// The plain innovations of these channels carry what the filter could not foresee of the table. If the table moves
// otherwise than its process, as in band-limited random motion, they are correlated though the chain is right. Between
// readings of the table on both sides hardly anything is left to foresee.
//
// What the later readings of the table say of its state b is Λ b - λ, an information filter that runs backwards:
//
//   reading y of row c:  Λ += c c'/σ²,  λ += c (y - bias)/σ²;    over an interval:  Λ = F' J Λ F,  λ = F' J λ,
//   J = (I + Λ q Q)⁻¹.   Innovation: mean and covariance x, P of the filter before the reading, with that taken in:
//   x + P_b (I + Λ P_bb)⁻¹ (λ - Λ x_b),   P - P_b (I + Λ P_bb)⁻¹ Λ P_b'.   (D. C. Fraser, J. E. Potter, 1969)
#pragma once

#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// Per channel of the rig, by time; none of those that show the table. As evaluate(), O(readings · states³).
[[nodiscard]] std::vector<std::vector<MotionInnovation>> innovations_given_table(const MotionModel& model,
                                                                                 const MotionData& data,
                                                                                 const MotionUnknowns& unknowns);

}  // namespace dwell
