// Whether the coefficients of any motion agree with those of a dwell of the same rig, and what it holds against them.
//
// An error of the rig file shifts both estimates alike where the transient tells no more than the steady motion. What
// then makes them differ is noise. Let d be the difference of a coefficient, and u_dwell and u_motion its standard
// uncertainties by noise alone:
//
//   var d = |u_dwell² - u_motion²|  if the motion's stretch holds nearly all readings of the dwell (Hausman 1978: the
//                                   motion's estimate is the more efficient one); at least a tenth of the larger
//   var d = u_dwell² + u_motion²    if it does not: the noise is then taken as independent
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/result/motion.hpp"

namespace dwell {

// Of all c and r that both have; nullopt: there is none. A coefficient contradicts if it differs by more than the joint
// U95 of both, and by more than noise makes one of them differ in one of 1000 dwells (Bonferroni). Thread-safe;
// allocates; some operations per coefficient.
[[nodiscard]] std::optional<Agreement> agreement_of(const MotionEstimate& motion, const Dwell& dwell);

// What any motion holds against a dwell, the first of these that is so. The estimate must overlap the dwell's hold,
// transient included:
//
// - the readings contradict the chain. The dwell's coefficients rest on the same chain, and one steady frequency cannot
//   show that by itself. The estimate must then reach into the dwell's own data: a knock in the transient contradicts
//   the chain as well, and is over when the dwell has settled;
// - a coefficient differs from the dwell's by five joint standard uncertainties. The rig, a transducer or a clock
//   changed on the way, and each dwell by itself looks well. Or harmonics of the drive fold onto the fundamental: named
//   are the channels for which the dwell's budget has a share "folded harmonics of …";
// - terms are named that explain the readings better, and one of them would move a coefficient of the dwell beyond its
//   U95.
//
// Beside these, readings of the table that err in a pattern: the dwell's ± takes the error for noise. It counts if the
// estimate has no `reason` against itself and reaches into the dwell's own data. How far a coefficient is off is not
// known, so by itself it is not grave. Beside a grave objection it is said of that one's elements alone.
struct Objection {
  std::string what;           // "any motion: the chain of the rig file does not explain y1; …"
  bool grave = true;          // false: nothing shows that a coefficient is so far off that it is wrong
  std::vector<int> elements;  // k of those concerned, ascending; empty: all
};

// nullopt: none is so. Thread-safe; allocates.
[[nodiscard]] std::optional<Objection> objection_to(const Dwell& dwell, const MotionEstimate& motion);
// Whether objection_to() is to be asked: the dwell has settled, and the estimate says something of the chain.
[[nodiscard]] bool may_object(const Dwell& dwell, const MotionEstimate& motion) noexcept;

}  // namespace dwell
