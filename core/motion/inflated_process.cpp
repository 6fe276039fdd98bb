#include "core/motion/inflated_process.hpp"

#include <algorithm>
#include <utility>

namespace dwell {
namespace {

// Logarithm of 100, the factor of the intensities. Three healthy rigs were told of a term that is not there. With 10,
// one of the three still is; with 1000, none. But with 1000 the residuals of two healthy rigs, read 6 and 14 times a
// period, look more like a wrong chain: the table is not known between its readings.
constexpr double kInflation = 4.6;

}  // namespace

MotionCourse with_inflated_process_noise(const Rig& rig, const MotionCourse& course) {
  MotionCourse inflated = course;
  MotionUnknowns at = course.fit.at;
  for (std::size_t i = 0; i < course.parameters.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    const Unknown what = course.parameters[i].what;
    if (what != Unknown::intensity && what != Unknown::noise) continue;
    if (what == Unknown::intensity) at.theta(a) += kInflation;
    inflated.limits.lowest(a) = std::max(inflated.limits.lowest(a), at.theta(a));
  }
  inflated.fit = fit_motion(course.model(rig), course.data, std::move(at), inflated.limits);
  return inflated;
}

}  // namespace dwell
