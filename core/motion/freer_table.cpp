#include "core/motion/freer_table.hpp"

#include <algorithm>
#include <utility>

namespace dwell {
namespace {

// Logarithm of 100. Ten or a thousand tell the same terms apart that are not there (docs/method.md).
constexpr double kFreer = 4.6;

}  // namespace

MotionCourse with_freer_table(const Rig& rig, const MotionCourse& course) {
  MotionCourse freer = course;
  MotionUnknowns at = course.fit.at;
  for (std::size_t i = 0; i < course.parameters.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    const Unknown what = course.parameters[i].what;
    if (what != Unknown::intensity && what != Unknown::noise) continue;
    if (what == Unknown::intensity) at.theta(a) += kFreer;
    freer.limits.lowest(a) = std::max(freer.limits.lowest(a), at.theta(a));
  }
  freer.fit = fit_motion(course.model(rig), course.data, std::move(at), freer.limits);
  return freer;
}

}  // namespace dwell
