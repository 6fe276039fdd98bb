// Are a dwell's residuals white? The phasor of each stretch of the dwell against that of the whole.
#pragma once

#include "core/blocks.hpp"
#include "core/harmonic_fit.hpp"

namespace dwell {

struct Scatter {
  double ratio = 1.0;  // variance of the stretches' phasors over what white residuals explain; 1 on average if they are
  double dof = 0.0;    // degrees of freedom behind it; 0: too little data to say
};

// Blocks [from, to) in about twelve stretches of at least a period; `fit`: of their sum about (omega, t_ref_ns) with
// `harmonics`. Residuals that hang together (hum, repeated readings, a sensor that has changed) make the ratio large.
// O(blocks · H), no allocation; `scratch` is overwritten in this channel.
[[nodiscard]] Scatter phasor_scatter(const Blocks& blocks, int from, int to, int channel, int harmonics,
                                     const HarmonicFit& fit, double omega, std::int64_t t_ref_ns,
                                     Totals& scratch) noexcept;

}  // namespace dwell
