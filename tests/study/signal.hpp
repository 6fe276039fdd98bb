// What the readings of a case tell of its parameters: their derivatives, each in units of its channel's noise. The
// Cramér-Rao bound of any parameter, and how far a fault stands out, are norms of what is left of such a column once
// all else has taken what it can of it. Written on the study's own motion; it shares nothing with core/motion.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

// A rig in motion as it truly is, from `start_s` on.
struct World {
  Chain chain;
  std::vector<Sensor> sensors;
  std::vector<SideSpring> side;
  TableMotion table;
  MassState state;
  double start_s = 0.0;
};
// Of a case whose drive begins at 0.
[[nodiscard]] World world_of(const Case& about);

struct ReadingAt {
  int channel;
  double t_s;
  double weight;  // one over its noise, times √(readings that it stands for)
};
// In (from, until], at random no more than about `most`; by time.
[[nodiscard]] std::vector<ReadingAt> readings_at(const Case& about, double from_s, double until_s, std::size_t most);

// What is read of this world, weighted.
[[nodiscard]] Eigen::VectorXd signal(const World& world, const std::vector<ReadingAt>& readings);

// The weighted derivatives, side by side: by ln c_1, ln r_1, ln c_2 …; then by what nothing states: amplitude and phase
// of each of the table's harmonics, its frequency, an offset of each channel, and where the motion begins from rest the
// instant at which it does (known_start) or else the state.
[[nodiscard]] Eigen::MatrixXd derivatives(const World& world, const std::vector<ReadingAt>& readings, bool known_start);

// Root of the sum of squares of what is left of `column` when `others` have taken what they can.
[[nodiscard]] double left_of(const Eigen::VectorXd& column, const Eigen::MatrixXd& others);

// Standard deviations of the first `count` parameters: the Cramér-Rao bound. Infinite where the readings do not tell.
[[nodiscard]] Eigen::VectorXd bound_of(const Eigen::MatrixXd& derivatives, Eigen::Index count);

}  // namespace dwell::study
