#include "core/transient/shown_modes.hpp"

#include <algorithm>

#include "core/transient/pole_search.hpp"

namespace dwell {

ShownModes::ShownModes(ChainPoles& chain, int channels, int harmonics, int modes, const FrequencyPrior& stated)
    : chain_(chain),
      seen_(channels),
      instants_(channels),
      whole_(channels, harmonics, modes, stated),
      imposed_(static_cast<std::size_t>(channels)),
      left_over_(static_cast<std::size_t>(channels)) {}

void ShownModes::remember(HoldFit& fit, const ResidualNoise& noise, std::int64_t free_since_ns,
                          const HoldNow& now) noexcept {
  ModalFit& modes = fit.fit();
  for (std::size_t i = 0; i < left_over_.size(); ++i) {
    const int c = static_cast<int>(i);
    left_over_[i] = modes.usable(c) ? std::max(0.0, noise.unexplained(c, modes, now)) : 0.0;
    imposed_[i] = now.channels[i].imposed;
  }
  instants_.look(fit, now);
  modes.step_poles(PoleSearch::kTrust, now.omega_given ? 0.0 : PoleSearch::kTrustOmega);
  modes.propagate_poles(now.omega_given);
  seen_.take(modes, now, instants_, left_over_);
  const std::int64_t oldest_ns = fit.history()[fit.history().begin()].t_ns;
  if (!noise.explained(modes, now) || oldest_ns > modes.t0_ns()) return;
  const WholeHold::Given given{
      fit.history(), modes,          chain_.seen_by(modes), imposed_, std::max(free_since_ns, oldest_ns),
      now.now_ns,    now.period_s(), now.omega_given};
  std::fill(left_over_.begin(), left_over_.end(), 0.0);
  // A fit that explains more of the hold replaces all before. A mode that only the replaced fits show was none.
  for (whole_.begin(given); whole_.earlier(given);) {
    seen_.clear();
    seen_.take(whole_.fit(), now, instants_, left_over_);
  }
}

}  // namespace dwell
