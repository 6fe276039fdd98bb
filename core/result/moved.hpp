// How far each coefficient has moved from one dwell to the next, and from which difference on it has moved. One
// definition for the page, for watch and for whoever reads the API: docs/method.md, "Whether a coefficient has moved".
#pragma once

#include <cstddef>
#include <vector>

#include "core/result/dwell.hpp"

namespace dwell {

// Part of the dwells in which chance alone may move any of their coefficients.
inline constexpr double kFalselyMoved = 0.05;

// A coefficient has moved if it differs by more than this many times √(U95² + U95²) of the two dwells. compared:
// number of coefficients judged together (Šidák 1967). moved_beyond(1) = 1. Pure, thread-safe.
[[nodiscard]] double moved_beyond(std::size_t compared) noexcept;

// For all coefficients of the dwell that have numbers; NaN: it has none.
[[nodiscard]] double moved_beyond(const Dwell& dwell) noexcept;

// The change of a coefficient since the dwell before, relative to its value there.
struct CoefficientMove {
  double change = kNaN;  // NaN: the dwell before has no number for it
  double U95 = kNaN;     // of the change: √(U95² + U95²) of the two dwells, relative too
  bool moved = false;    // |change| > moved_beyond() · U95
};
struct ElementMove {
  int k = 0;
  CoefficientMove stiffness, damping;
};

// Of every element that has numbers now. Thread-safe; allocates. O(elements²).
[[nodiscard]] std::vector<ElementMove> moves_since(const Dwell& before, const Dwell& now);

}  // namespace dwell
