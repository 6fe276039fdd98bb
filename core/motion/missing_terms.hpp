// What is missing, by name: of all physical terms and mistakes of a rig file that can be thought of, the one that
// explains what a chain leaves over, with those that the readings do not tell from it. docs/method.md, Any motion.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/motion/motion_course.hpp"
#include "core/result/missing.hpp"
#include "core/result/motion.hpp"

namespace dwell {

struct MissingTerms {
  std::vector<MissingTerm> terms;      // likeliest first: one, and those not told from it; empty: none is named
  std::vector<std::string> unchecked;  // what these readings cannot tell
  bool tried_inputs = false;           // friction and cubic stiffness, which need a fit to begin with
  AnewSearch anew = AnewSearch::not_asked;
  std::size_t untried = 0;  // hypotheses left when the time was spent
};

// data: as run_course() was given. contradicted: the chain is refused, or does not converge; then mistakes of the rig
// file are tried as well, each with the chain fitted anew, unless that is put off (anew: false). Takes a third of the
// time of the estimate on a healthy rig, and up to three estimates where a term is found and checked against a swell.
// On a contradicted one screening takes up to ten times the time of the estimate, and each hypothesis that is close to
// the best one estimate more, a delay two. Thread-safe; allocates.
[[nodiscard]] MissingTerms find_missing(const Rig& rig, const MotionData& data, const MotionCourse& course,
                                        bool contradicted, std::size_t most, bool anew);

}  // namespace dwell
