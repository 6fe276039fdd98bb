// The frequency that the rig file states, as a Gaussian prior of the estimate.
//
// The data show ω on the axis of the samples' stamps, whose rate is off by clock_u. A frequency that is `fixed` is
// therefore known there with
//
//   u² = (2π frequency_u)² + (ω clock_u)²
//
// and the estimate adds the prior's score (ω_0 - ω)/u² and information 1/u² to those of the data: `fixed` is `tracked`
// with a prior. Pure, thread-safe, real-time safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct FrequencyPrior {
  double omega = 0.0;                                  // ω_0, rad/s
  double u = std::numeric_limits<double>::infinity();  // rad/s; 0: exact; infinity: nothing is stated

  // Standard deviations beyond which data and statement contradict each other: once in 16 000 dwells by chance. Half of
  // it would cry wolf in every twentieth dwell; twice would leave a clock off by 400 ppm unsaid.
  static constexpr double kContradicts = 4.0;

  [[nodiscard]] bool stated() const noexcept { return std::isfinite(u); }
  [[nodiscard]] bool exact() const noexcept { return u == 0; }
  [[nodiscard]] double score(double w) const noexcept { return stated() && !exact() ? (omega - w) / (u * u) : 0.0; }
  [[nodiscard]] double information() const noexcept { return stated() && !exact() ? 1 / (u * u) : 0.0; }
  // ω no further from the statement than where it would contradict it.
  [[nodiscard]] double within(double w) const noexcept {
    return stated() ? std::clamp(w, omega - kContradicts * u, omega + kContradicts * u) : w;
  }
  // Whether data that alone say ω, with standard uncertainty u_data, contradict the statement.
  [[nodiscard]] bool contradicted(double w, double u_data) const noexcept {
    return stated() && std::abs(w - omega) > kContradicts * std::hypot(u, u_data);
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
