// A transducer's low-pass or high-pass as differential equations: a cascade of sections of first and second order,
// whose states move with the chain's. Its frequency response is filter_response() of core/rig/transducer.hpp.
//
//   first order:   x' = w (u - x)                                  low: x       high: u - x
//   second order:  x1' = w x2,  x2' = w (u - x1) - 2 ζ w x2        low: x1      high: u - x1 - 2 ζ x2
#pragma once

#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

struct FilterSection {
  int order = 1;         // 1 or 2
  double w = 0.0;        // rad/s; proportional to the filter's corner
  double damping = 0.0;  // ζ, of a second-order section
};

// The sections of a filter, none for FilterKind::none. Allocates; thread-safe.
[[nodiscard]] std::vector<FilterSection> filter_sections(const Filter& filter, bool high);

// States of all sections together.
[[nodiscard]] int state_count(const Filter& filter);

}  // namespace dwell
