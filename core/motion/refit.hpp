// A fit again with one more term free, from where the fit without it ended.
#pragma once

#include <Eigen/Core>

#include "core/motion/leftover.hpp"
#include "core/motion/motion_course.hpp"

namespace dwell {

struct Refit {
  bool converged = false;
  double gain = 0.0;   // by which V fell; V before includes the term's prior, if it had one, V after does not
  double value = 0.0;  // of the term: departure from what is stated, or its size
  double u = 0.0;      // by the readings alone, wider where the innovations are not white
  Leftover left;
  Eigen::VectorXd moves;  // change of (c, r) of each element
};

// The same readings, those of one channel stamped later by `by_s`, in the order of their new instants.
[[nodiscard]] MotionData shifted(MotionData data, int channel, double by_s);

// course.fit: converged. start and value: the maximum that the score test expects; used if V is lower there than at the
// fit without the term. A delay is not bound to the first terms that the model has of it: the stamps are shifted by
// what was found. Some five to ten passes with derivatives, up to as many as a fit takes at most where the fault is
// large. Allocates; thread-safe.
[[nodiscard]] Refit refit_with(const Rig& rig, const MotionCourse& course, const Parameter& term,
                               const MotionUnknowns& start, double value);

}  // namespace dwell
