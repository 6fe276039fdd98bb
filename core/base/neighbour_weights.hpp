// Weights with which a polynomial through a reading's neighbours foresees it. It misses noise and
// fast motion.
#pragma once

#include <cstddef>

namespace dwell {

// A normal distribution's standard deviation over its median deviation.
inline constexpr double kSigmaOfMedian = 1.4826;

// Fills weights[0 … 2·beside]. t: as many instants, rising, in any unit. A polynomial of degree 2·beside - 1 goes
// through all readings but the middle one. At the middle's instant it is Σ weights[i] x[i] over these (Lagrange). The
// middle's own weight is -1, so that the sum over all readings is foreseen less read. Of neighbours with one instant,
// as rounded stamps give them, the polynomial goes through the mean; its degree falls with the number of instants.
// Thread-safe, real-time safe; (2·beside)² divisions.
inline void neighbour_weights(const double* t, std::size_t beside, double* weights) noexcept {
  const auto is_repeated = [&](std::size_t i) {  // the neighbour before has the same instant
    const std::size_t before = i == beside + 1 ? 2U : 1U;
    return i >= before && t[i - before] == t[i];
  };
  weights[beside] = -1.0;
  for (std::size_t a = 0; a <= 2 * beside; ++a) {
    if (a == beside) continue;
    double weight = 1.0, alike = 0.0;
    for (std::size_t b = 0; b <= 2 * beside; ++b) {
      if (b == beside) continue;
      if (t[b] == t[a])
        alike += 1.0;
      else if (!is_repeated(b))
        weight *= (t[beside] - t[b]) / (t[a] - t[b]);
    }
    weights[a] = weight / alike;
  }
}

}  // namespace dwell
