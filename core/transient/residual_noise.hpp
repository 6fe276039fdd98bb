// Tells whether the residuals of the modal fit are noise. The noise of each channel is known from quarters of a period,
// in which a mean, a sine and a cosine follow any smooth motion. The poles do not explain everything where the
// residuals exceed this noise, or where they are larger in the fit's earlier half than in its later.
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
  // Adds the residuals of one more window of a channel: their sum of squares and degrees of freedom. All windows before
  // count at most eight times as much as this one.
  void learn(int channel, double squares, double freedom) noexcept;
  // Whether the noise is known well enough to compare residuals with it.
  [[nodiscard]] bool known(int channel) const noexcept { return at(channel).freedom >= 4; }
  // The learned variance of the noise, and its degrees of freedom. Infinity: nothing is known.
  [[nodiscard]] double variance(int channel) const noexcept { return at(channel).variance; }
  [[nodiscard]] double freedom(int channel) const noexcept { return at(channel).freedom; }
  // The smallest of three estimates of the noise: as learned, by the fit's residuals, by those of its later half.
  [[nodiscard]] double smallest_variance(int channel, const ModalFit& fit) const noexcept;

  // Computes the variance of the residuals in the earlier and in the later half of the fit. Residuals of wrong poles
  // decay; noise does not. The result stays until the next call. O(samples).
  void compare_halves(HoldFit& fit, std::int64_t now_ns) noexcept;
  // Variance of a channel's residuals beyond its noise; 0 or less: the fit explains the channel.
  [[nodiscard]] double unexplained(int channel, const ModalFit& fit, const HoldNow& now) const noexcept;
  // Whether the fit explains every channel that it has solved, the imposed ones aside.
  [[nodiscard]] bool explained(const ModalFit& fit, const HoldNow& now) const noexcept;

 private:
  struct PerChannel {
    double variance = INFINITY, freedom = 0.0;
    // Variance of the residuals in either half of the fit, and their numbers.
    double earlier = 0.0, later = 0.0, in_earlier = 0.0, in_later = 0.0;
  };
  [[nodiscard]] const PerChannel& at(int channel) const noexcept {
    return channels_[static_cast<std::size_t>(channel)];
  }

  std::vector<PerChannel> channels_;
};

}  // namespace dwell
