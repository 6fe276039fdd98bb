// What friction and a cubic stiffness make of the motion, as inputs of the model (is_input()): the direction of an
// element's rate or of a mass's velocity, and the cube of an element's deformation.
//
// Both are taken from the state that the filter predicts, never from a reading that is yet to come. So under a right
// model the innovations are independent of them, and a test of their amplitude is exact.
#pragma once

#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// One per input of `wanted`, in its order, with as many values as there are readings. model, data and at: any that fit
// each other. Allocates; thread-safe. One pass without derivatives.
[[nodiscard]] std::vector<MotionInput> element_inputs(const MotionModel& model, const MotionData& data,
                                                      const MotionUnknowns& at, const std::vector<Parameter>& wanted);

}  // namespace dwell
