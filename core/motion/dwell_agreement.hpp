// Whether the coefficients of any motion agree with those of a dwell of the same rig, and what it holds against them.
//
// An error of the rig file shifts both estimates alike where the transient tells no more than the steady motion. What
// then makes them differ is noise. Let d be the difference of a coefficient, and u_dwell and u_motion its standard
// uncertainties by noise alone:
//
//   var d = u_dwell² - u_motion²   if the motion's stretch holds all readings of the dwell (Hausman 1978: the motion's
//                                  estimate uses more of them and is the more efficient one)
//   var d = u_dwell² + u_motion²   if it does not: the noise is then taken as independent
#pragma once

#include <optional>
#include <string>

#include "core/result/motion.hpp"

namespace dwell {

// Of all c and r that both have; nullopt: there is none. A coefficient contradicts if it differs by more than the joint
// U95 of both, and by more than noise makes one of them differ in 5 % of cases (Bonferroni). Thread-safe; allocates;
// some operations per coefficient.
[[nodiscard]] std::optional<Agreement> agreement_of(const MotionEstimate& motion, const Dwell& dwell);

// What speaks against a dwell where the readings of a stretch that it lies in contradict the chain: its coefficients
// rest on the same chain. One steady frequency cannot show that by itself.
struct Objection {
  std::string what;   // "any motion: the chain of the rig file does not explain y1; …"
  bool grave = true;  // false: the term that explains it moves no coefficient by more than its U95
};

// nullopt: the chain is not contradicted, or not where the dwell's data lie. Thread-safe; allocates.
[[nodiscard]] std::optional<Objection> objection_to(const Dwell& dwell, const MotionEstimate& motion);

}  // namespace dwell
