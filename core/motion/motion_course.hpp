// The way to the largest likelihood: a start from the weak form, then more and more of the readings, events of the
// table given an intensity of their own, what the rig file states with an uncertainty last.
//
// A lightly damped chain whose frequency is off by δ is out of phase after 1/δ: the likelihood of a long stretch has
// many maxima. That of a short one has one, and tells the next start well enough.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/motion/motion_fit.hpp"
#include "core/motion/table_activity.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct MotionCourse {
  std::string reason;  // why the fit must not be reported, which may be filled all the same; empty: it may
  MotionFit fit;
  FitLimits limits;  // of that fit
  TableProcess process = TableProcess::wandering;
  std::vector<Parameter> parameters;  // of fit.at.theta
  MotionData data;                    // as fitted, with its stretches
  std::vector<double> noise;          // local_noise() of each channel, SI
  std::vector<double> size;           // rms about the mean of each channel, SI
  bool whole = false;                 // fit is of all readings of `data`
  int passes = 0;
  // That of the fit. rig: the one of the course.
  [[nodiscard]] MotionModel model(const Rig& rig) const { return {rig, parameters, process}; }
};

// Takes at most `most` readings from the start of the motion on. term: one more parameter, fitted without a prior even
// if the rig file states one; must not be an input (is_input()). Allocates; thread-safe. Throws Stopped soon after stop
// was requested.
[[nodiscard]] MotionCourse run_course(const Rig& rig, MotionData data, std::size_t most,
                                      const std::optional<Parameter>& term = {}, std::stop_token stop = {},
                                      TableProcess process = TableProcess::wandering);

// Lowest departure of a mass from what is stated, kg: below it the chain is another.
[[nodiscard]] double lowest_departure(double mass);

}  // namespace dwell
