// The test repeated virtually: computes from the table's measured motion and a chain's coefficients what every
// transducer would have read at its own instants (docs/method.md, Verification). Exact for the interpolated input, up
// to rounding. Does not assume a steady motion.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/verify/virtual_test_input.hpp"
#include "core/verify/virtual_test_model.hpp"

namespace dwell {

// Instants of a channel's readings as stamped, ns, not decreasing; empty: the channel is not asked for.
using Instants = std::vector<std::int64_t>;

// A channel's predicted readings, SI: one row per player of the test, one column per instant.
using PredictedReadings = Eigen::MatrixXd;

class VirtualTest {
 public:
  // table: index of a channel that shows_drive(). The chain must have no fault(). Allocates; O(n³).
  VirtualTest(const Rig& rig, const Chain& chain, int table) : model_(rig, chain, table) {}

  // Why it cannot be played; empty: it can.
  [[nodiscard]] const std::string& fault() const noexcept { return model_.fault(); }
  [[nodiscard]] const VirtualTestModel& model() const noexcept { return model_; }

  // Plays the test from the input's first knot on. Player r < input.readings() has that reading of the table, every
  // other one a table at rest; initial: one column per player, states() rows. instants: one per channel of the rig; NaN
  // where one, the delay taken off, is outside the input. O(instants · players · states²). Allocates; thread-safe.
  [[nodiscard]] std::vector<PredictedReadings> play(const VirtualTestInput& input, const Eigen::MatrixXd& initial,
                                                    const std::vector<Instants>& instants) const;

 private:
  VirtualTestModel model_;
};

}  // namespace dwell
