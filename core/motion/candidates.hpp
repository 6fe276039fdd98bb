// What the model of a rig may lack, one physical term each: a mass, a scale or a delay that is off; a spring, a damper
// or Coulomb friction from a mass to ground; a spring between places that no element joins; Coulomb friction and a
// cubic stiffness of an element.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/unknowns.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// All terms that can be thought of for this rig, none with a prior.
[[nodiscard]] std::vector<Parameter> missing_candidates(const Rig& rig);

// A size that would change the motion altogether: the whole mass, scale, a radian of delay, a spring as strong as the
// mass's inertia, friction as strong as the element. In the parameter's unit, above 0.
// deformation: of each element, amplitude in m (rad); stiffness, damping: of each element.
struct ElementSizes {
  Eigen::VectorXd stiffness, damping, deformation;
};
[[nodiscard]] double natural_size(const Rig& rig, const Parameter& candidate, const ElementSizes& elements);

// Whether the value is physical: a mass stays above 0; friction, springs and dampers are above 0; a delay stays within
// half a radian of the drive; a scale falls by less than half (a reversed channel is another explanation).
[[nodiscard]] bool is_possible(const Rig& rig, const Parameter& candidate, double value);

}  // namespace dwell
