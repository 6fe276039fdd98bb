// The frequency stated in the rig file, as a Gaussian prior of the estimate.
//
// The data show ω by the clock of the stamps, whose rate has the standard uncertainty clock_u. By that clock a `fixed`
// frequency has the standard uncertainty u,
//
//   u² = (2π frequency_u)² + (ω_0 clock_u)² .
//
// The estimate adds the prior's score (ω_0 - ω)/u² and information 1/u² to those of the data. So `fixed` is `tracked`
// with a prior. Pure, thread-safe, real-time safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct FrequencyPrior {
  double omega = 0.0;                                  // ω_0, rad/s
  double u = std::numeric_limits<double>::infinity();  // rad/s; 0: exact; infinity: nothing is stated

  [[nodiscard]] bool stated() const noexcept { return std::isfinite(u); }
  [[nodiscard]] bool exact() const noexcept { return u == 0; }
  [[nodiscard]] double score(double w) const noexcept { return stated() && !exact() ? (omega - w) / (u * u) : 0.0; }
  [[nodiscard]] double information() const noexcept { return stated() && !exact() ? 1 / (u * u) : 0.0; }
  // ω, limited to the range that does not contradict the statement.
  [[nodiscard]] double within(double w) const noexcept {
    return stated() ? std::clamp(w, omega - sigmas::kShown * u, omega + sigmas::kShown * u) : w;
  }
  // Whether ω by the data alone, with standard uncertainty u_data, contradicts the statement.
  [[nodiscard]] bool contradicted(double w, double u_data) const noexcept {
    return stated() && std::abs(w - omega) > sigmas::kShown * std::hypot(u, u_data);
  }
};

[[nodiscard]] inline FrequencyPrior stated_frequency(const Rig& rig) noexcept {
  const Excitation& drive = rig.excitation;
  FrequencyPrior prior{.omega = kTwoPi * drive.frequency_hz};
  if (drive.reference == Reference::fixed)
    prior.u = std::hypot(kTwoPi * drive.frequency_u_hz, prior.omega * drive.clock_u);
  return prior;
}

}  // namespace dwell
