// Which answers of a device were held up on their way, by the half widths of their instants.
#pragma once

#include "core/intake/median_step.hpp"

namespace dwell {

// Of one channel. One thread; real-time safe.
class AnswerLateness {
 public:
  static constexpr double kHeldUp = 1.5;  // times the usual half width
  static constexpr double kByFar = 5.0;   // medians; exponentially distributed delays exceed it in 3 % (2⁻⁵)
  static constexpr double kRare = 0.1;    // of the answers: so many may be left out, which widens u by at most 5 %
  // Largest half width times slope with which a held-up answer still counts, in standard deviations of the noise: √6.
  // An error evenly distributed over ± √6 σ has the variance 2 σ². Smaller: answers that would help are left out.
  static constexpr double kUncertain = 2.449;

  // The next answer. first: the median has not been learnt yet. The first answer may be a late one, so the median moves
  // five times as fast at first.
  void see(double half_ns, bool first) noexcept {
    if (median_ns_ == 0.0) median_ns_ = half_ns;
    const double learn = first ? 5 * kMedianStep : kMedianStep;
    median_ns_ *= half_ns > median_ns_ ? 1 + learn : 1 - learn;
    const bool far = by_far(half_ns);
    if (far || part_ > 0) part_ += kLearnRare * ((far ? 1.0 : 0.0) - part_);
  }
  [[nodiscard]] bool held_up(double half_ns) const noexcept { return half_ns > kHeldUp * median_ns_; }
  [[nodiscard]] bool by_far(double half_ns) const noexcept { return half_ns > kByFar * median_ns_; }
  // Few answers are late by far.
  [[nodiscard]] bool rare() const noexcept { return part_ < kRare; }

 private:
  static constexpr double kLearnRare = 1.0 / 256.0;  // one in twenty is then known to 0.01

  double median_ns_ = 0.0;  // running, of the half widths; 0: there is none
  double part_ = 0.0;       // running, of the answers that are late by far
};

}  // namespace dwell
