// A transducer's low-pass or high-pass as differential equations: a cascade of sections of first and second order,
// whose states move with the chain's. Its frequency response is filter_response() of core/rig/transducer.hpp.
//
//   first order:   x' = w (u - x)                                  low: x       high: u - x
//   second order:  x1' = w x2,  x2' = w (u - x1) - 2 ζ w x2        low: x1      high: u - x1 - 2 ζ x2
#pragma once

#include <Eigen/Core>
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

// Adds a filter to the linear system x' = A x: its states are those from `first` on. input: the row of x that the
// filter sees. Returns the row of x that it shows. couple_only: adds the input's part alone, of A and of the row, which
// is what a derivative by a parameter of the input has.
[[nodiscard]] Eigen::RowVectorXd add_filter(const Filter& filter, bool high, Eigen::RowVectorXd input,
                                            Eigen::Index first, Eigen::MatrixXd& A, bool couple_only = false);

// Coefficients p_0 … p_order of the polynomial P with H_low(s) = 1/P(s/ω_c), p_0 = 1; H_high(s) = 1/P(ω_c/s).
// Allocates; thread-safe.
[[nodiscard]] std::vector<double> filter_polynomial(const Filter& filter);

}  // namespace dwell
