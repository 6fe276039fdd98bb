// A reading as a polynomial through its neighbours foresees it, and what that leaves as a noise.
#pragma once

#include <cstddef>

namespace dwell {

// A normal distribution's standard deviation over its median deviation.
inline constexpr double kSigmaOfMedian = 1.4826;

// t: 2·beside + 1 instants, rising, in any unit. weights[i] is that of the reading at t[i] in the polynomial of degree
// 2·beside - 1 through all but the middle one, at its instant (Lagrange); the middle's is -1. Equal instants count as
// one and leave their weights finite. Thread-safe, real-time safe; (2·beside)² divisions.
inline void neighbour_weights(const double* t, std::size_t beside, double* weights) noexcept {
  weights[beside] = -1.0;
  for (std::size_t a = 0; a <= 2 * beside; ++a) {
    if (a == beside) continue;
    double weight = 1.0;
    for (std::size_t b = 0; b <= 2 * beside; ++b)
      if (b != beside && b != a && t[a] != t[b]) weight *= (t[beside] - t[b]) / (t[a] - t[b]);
    weights[a] = weight;
  }
}

}  // namespace dwell
