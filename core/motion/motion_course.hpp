// The way to the largest likelihood: a start from the weak form, then more and more of the readings, events of the
// table given an intensity of their own, what the rig file states with an uncertainty last.
//
// A lightly damped chain whose frequency is off by δ is out of phase after 1/δ: the likelihood of a long stretch has
// many maxima. That of a short one has one, and tells the next start well enough.
#pragma once

#include <string>
#include <vector>

#include "core/motion/motion_fit.hpp"
#include "core/motion/table_activity.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct MotionCourse {
  std::string reason;  // why there is no fit; empty: there is
  MotionFit fit;
  std::vector<Parameter> parameters;  // of fit.at.theta
  MotionData data;                    // as fitted, with its stretches
  std::vector<double> noise;          // local_noise() of each channel, SI
  std::vector<double> size;           // rms about the mean of each channel, SI
  std::size_t spikes = 0;             // readings left out beforehand
  int passes = 0;
};

// Takes at most `most` readings from the start of the motion on. Allocates; thread-safe.
[[nodiscard]] MotionCourse run_course(const Rig& rig, MotionData data, std::size_t most);

}  // namespace dwell
