#include "core/motion/step_control.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

constexpr double kMostDamping = 1e6;
// Where none is known that served. A direction that is told by itself goes two thirds of its step, one that is hardly
// told from others much less.
constexpr double kFirstDamping = 0.5;
// Gains above kGood take damping away, gains below kPoor add some.
constexpr double kGood = 0.6, kPoor = 0.3;
constexpr double kFlat = 0.5;  // of the information: where the curvature is that, twice the step is the best one

}  // namespace

bool StepControl::spent() const noexcept { return damping_ >= kMostDamping; }

void StepControl::learn(double gain) noexcept {
  // A function of c times the information's curvature gains 2 f - c f² by an undamped step times f.
  const double curvature = (2 * factor_ - gain) / (factor_ * factor_);
  const bool flat = gain > 0 && curvature < kFlat;
  if (gain > kPoor || factor_ == 1.0) damp(gain);
  factor_ = flat && flat_ ? 2.0 : 1.0;
  flat_ = flat;
}

void StepControl::damp(double gain) noexcept {
  if (gain > kPoor) {
    served_ = damping_;
    poor_ = 0;
    if (gain > kGood) damping_ = std::max(kLeastDamping, 0.1 * damping_);
    return;
  }
  ++poor_;
  if (served_ > damping_ && poor_ <= 2)
    damping_ = poor_ == 1 ? std::sqrt(served_ * damping_) : served_;
  else
    damping_ = std::max(kFirstDamping, 4.0 * damping_);
}

}  // namespace dwell
