#include "core/motion/gain_schedule.hpp"

#include <cstdlib>
#include <utility>

namespace dwell {
namespace {

constexpr std::int64_t kSameInterval_ns = 2;  // stamps of 300 Hz in whole ns alternate by 1 ns
// Changes of a gain from scan to scan below which it is steady. What is left to come is the change over the rate at
// which it decays, which is above 1e-3 per scan where anything is learnt: 1e-7 of the gain.
constexpr double kSteadyGain = 1e-10, kSteadyDerivative = 1e-8;
constexpr std::size_t kLongestCycle = 256;

}  // namespace

bool GainSchedule::same_place(const Slot& slot, std::int64_t dt_ns, int channel, int stretch) noexcept {
  return slot.channel == channel && slot.stretch == stretch && std::abs(slot.dt_ns - dt_ns) <= kSameInterval_ns;
}

bool GainSchedule::steady(const KalmanGain& before, const KalmanGain& now) {
  if (before.K.size() != now.K.size() || (before.K - now.K).norm() > kSteadyGain * now.K.norm()) return false;
  if (largest_dK_.size() != now.dK.cols()) largest_dK_.setZero(now.dK.cols());
  bool all = true;
  for (Eigen::Index a = 0; a < now.dK.cols(); ++a) {
    largest_dK_(a) = std::max(largest_dK_(a), now.dK.col(a).norm());
    all = all && (before.dK.col(a) - now.dK.col(a)).norm() <= kSteadyDerivative * largest_dK_(a);
  }
  return all;
}

void GainSchedule::run(std::int64_t dt_ns, int channel, int stretch, KalmanGain& out) {
  if (dt_ns > 0) filter_.propagate(steps_.over(dt_ns), steps_.derivative_of(), stretch);
  filter_.take(channel, out);
}

// The covariance stands where the cycle began: brings it to the slot that did not come.
void GainSchedule::thaw() {
  frozen_ = false;
  for (std::size_t i = 0; i < at_; ++i) run(cycle_[i].dt_ns, cycle_[i].channel, cycle_[i].stretch, now_);
  repeats_ = false;
}

GainSchedule::Due GainSchedule::next(std::int64_t dt_ns, int channel, int stretch) {
  if (frozen_ && !same_place(cycle_[at_], dt_ns, channel, stretch)) thaw();
  if (!frozen_ && at_ > 0 && (channel == cycle_.front().channel || at_ == kLongestCycle)) {
    frozen_ = repeats_ && at_ == cycle_.size() && same_place(cycle_.front(), dt_ns, channel, stretch);
    cycle_.resize(at_);
    at_ = 0;
    repeats_ = true;
  }
  if (!frozen_) {
    const bool again = at_ < cycle_.size() && same_place(cycle_[at_], dt_ns, channel, stretch);
    if (again) dt_ns = cycle_[at_].dt_ns;
    run(dt_ns, channel, stretch, now_);
    repeats_ = repeats_ && again && steady(cycle_[at_].gain, now_);
    if (at_ == cycle_.size()) cycle_.emplace_back();
    std::swap(cycle_[at_].gain, now_);
    cycle_[at_].dt_ns = dt_ns;
    cycle_[at_].channel = channel;
    cycle_[at_].stretch = stretch;
  }
  const Slot& slot = cycle_[at_];
  const Due due{slot.dt_ns > 0 ? &steps_.over(slot.dt_ns) : nullptr, &slot.gain, slot.dt_ns};
  if (++at_ == cycle_.size() && frozen_) at_ = 0;
  return due;
}

}  // namespace dwell
