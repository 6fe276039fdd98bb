// From which difference on a coefficient has moved from one dwell to the next. One definition for the page, for watch
// and for whoever reads the API: docs/method.md, "Whether a coefficient has moved".
#pragma once

#include <cstddef>

#include "core/result/dwell.hpp"

namespace dwell {

// Part of the dwells in which chance alone may move any of their coefficients.
inline constexpr double kFalselyMoved = 0.05;

// A coefficient has moved if it differs by more than this many times √(U95² + U95²) of the two dwells. compared:
// number of coefficients judged together (Šidák 1967). moved_beyond(1) = 1. Pure, thread-safe.
[[nodiscard]] double moved_beyond(std::size_t compared) noexcept;

// For all coefficients of the dwell that have numbers; NaN: it has none.
[[nodiscard]] double moved_beyond(const Dwell& dwell) noexcept;

}  // namespace dwell
