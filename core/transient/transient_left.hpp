// Compares what may be left of the transient in each channel with what is allowed: for verdicts, and to take one back.
#pragma once

#include <cstdint>
#include <optional>

#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/residual_noise.hpp"
#include "core/transient/settling.hpp"

namespace dwell {

// Bound to one thread, real-time safe. `left` is relative to what is allowed, with a safety margin in Worst::left:
// settled at 1 or less.
class TransientLeft {
 public:
  // tolerance: the transient allowed, relative to a channel's steady amplitude. fit and noise must outlive this.
  TransientLeft(double tolerance, const HoldFit& fit, const ResidualNoise& noise)
      : tolerance_(tolerance), fit_(fit), noise_(noise) {}

  // Where most may be left at t: what the fit shows and three standard deviations, or the residuals beyond the noise.
  // left: infinity if a watched channel is not fitted; `channel` is then not valid. channel: -1 if nothing is left.
  struct Worst {
    double left = 0.0;
    int channel = -1;
  };
  [[nodiscard]] Worst at(std::int64_t t_ns, const HoldNow& now) const noexcept;
  // Writes at() into a verdict. The verdict's channel stays where nothing is left in any.
  void tell(std::int64_t t_ns, const HoldNow& now, SettlingDetector::Verdict& verdict) const noexcept;

  // From where the data count after a verdict at end_ns; empty: too few data would.
  [[nodiscard]] std::optional<std::int64_t> counts_from(std::int64_t end_ns, const HoldNow& now) const noexcept;
  // Whether rounding hides the noise of any channel.
  [[nodiscard]] bool rounded(const HoldNow& now) const noexcept;

  // A verdict that was premature.
  struct Premature {
    std::int64_t verdict_ns;
    int channel;  // in which most was left
    double left;  // what was left there, as fitted, relative to what is allowed
  };
  // The worst channel with more left at the verdict than allowed, by sigmas::kNoise standard deviations; empty: there
  // is none.
  [[nodiscard]] std::optional<Premature> premature(std::int64_t verdict_ns, const HoldNow& now) const noexcept;

 private:
  // What may be left in a channel, its unit: the tolerance of its amplitude, at least what ten periods' noise hides.
  [[nodiscard]] double allowed(int channel, const HoldNow& now) const noexcept;
  [[nodiscard]] bool hidden_by_rounding(int channel, const HoldNow& now) const noexcept;

  double tolerance_;
  const HoldFit& fit_;
  const ResidualNoise& noise_;
};

}  // namespace dwell
