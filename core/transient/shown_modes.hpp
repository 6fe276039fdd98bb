// Keeps the natural oscillations that a hold has shown, for the cross-check of the model. They come from the fit that
// judges the transient, and from a fit of the whole hold where that explains the data.
#pragma once

#include <span>
#include <vector>

#include "core/transient/chain_poles.hpp"
#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/residual_noise.hpp"
#include "core/transient/seen_modes.hpp"
#include "core/transient/whole_hold.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor.
class ShownModes {
 public:
  // modes: capacity in poles. stated: prior of the drive's frequency. chain must outlive this.
  ShownModes(ChainPoles& chain, int channels, int harmonics, int modes, const FrequencyPrior& stated);

  void begin_hold() noexcept { seen_.clear(); }
  // Keeps the modes that the fit shows. free_since_ns: when they began. Costs up to 0.3 s of a processor (WholeHold).
  void remember(HoldFit& fit, const ResidualNoise& noise, std::int64_t free_since_ns, const HoldNow& now) noexcept;
  [[nodiscard]] std::span<const SeenMode> modes() const noexcept { return seen_.modes(); }

 private:
  ChainPoles& chain_;
  SeenModes seen_;
  SharedInstants instants_;
  WholeHold whole_;
  std::vector<char> imposed_;      // per channel: it shows the table
  std::vector<double> left_over_;  // per channel, variance of its residuals beyond the noise
};

}  // namespace dwell
