// What the fit of natural oscillations leaves over: is it noise? The noise of each channel is known from stretches of a
// quarter of a period, in which a mean, a sine and a cosine follow any smooth motion. Residuals of a fit that exceed
// it, or that are larger in the fit's earlier half than in its later, hold something that the poles do not explain.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor. Variances in the channel's unit squared.
class ResidualNoise {
 public:
  explicit ResidualNoise(int channels) : channels_(static_cast<std::size_t>(channels)) {}

  // Forgets all.
  void begin_hold() noexcept;
  // A period more of a channel: its residuals' squares and their degrees of freedom. The newest period counts at least
  // an eighth of all.
  void learn(int channel, double squares, double freedom) noexcept;
  // Whether the noise is known well enough to hold residuals against it.
  [[nodiscard]] bool known(int channel) const noexcept { return at(channel).freedom >= 4; }
  // Infinity: nothing is known.
  [[nodiscard]] double variance(int channel) const noexcept { return at(channel).variance; }
  [[nodiscard]] double freedom(int channel) const noexcept { return at(channel).freedom; }
  // The smallest that the noise may be: what is known of it, and what the fit leaves over.
  [[nodiscard]] double floor(int channel, const ModalFit& fit) const noexcept;

  // Looks at the residuals of the earlier half of the fit and of the later: what a wrong set of poles leaves over
  // decays, noise does not. Stays until the next call. O(samples).
  void compare_halves(HoldFit& fit, std::int64_t now_ns) noexcept;
  // Variance of a channel's residuals beyond its noise; not above 0: none.
  [[nodiscard]] double unexplained(int channel, const ModalFit& fit, const HoldNow& now) const noexcept;
  // Whether every channel's residuals are no more than its noise.
  [[nodiscard]] bool explained(const ModalFit& fit, const HoldNow& now) const noexcept;

 private:
  struct PerChannel {
    double variance = INFINITY, freedom = 0.0;
    // Of the fit's residuals in either half of it, and their numbers.
    double earlier = 0.0, later = 0.0, in_earlier = 0.0, in_later = 0.0;
  };
  [[nodiscard]] const PerChannel& at(int channel) const noexcept {
    return channels_[static_cast<std::size_t>(channel)];
  }

  std::vector<PerChannel> channels_;
};

}  // namespace dwell
