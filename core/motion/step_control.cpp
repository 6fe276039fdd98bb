#include "core/motion/stride.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

constexpr double kMostDamping = 1e6;
constexpr double kHalfLength = 0.5;  // damping after a step that went too far, where none that served is known
constexpr double kGood = 0.6, kPoor = 0.3;
constexpr double kFlat = 0.5;  // of the information: where the curvature is that, twice the step is the best one

}  // namespace

bool Stride::spent() const noexcept { return damping_ >= kMostDamping; }

void Stride::learn(double gain) noexcept {
  // A function of c times the information's curvature gains 2 s - c s² by a step that is stretched by s.
  const double curvature = (2 * stretch_ - gain) / (stretch_ * stretch_);
  const bool flat = gain > 0 && curvature < kFlat;
  if (gain > kPoor || stretch_ == 1.0) damp(gain);
  stretch_ = flat && flat_ ? 2.0 : 1.0;
  flat_ = flat;
}

void Stride::damp(double gain) noexcept {
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
    damping_ = std::max(kHalfLength, 4.0 * damping_);
}

}  // namespace dwell
