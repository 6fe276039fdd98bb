// The table's noise kept out of the virtual test where the table moves steadily: there its readings are replaced by the
// harmonics of the drive that fit them best. A lightly damped chain would otherwise answer the noise of the table as
// if it had moved: at Q = 130 and twelve readings a period eight times the noise.
//
// Steady is the longest stretch up to the end in which what the harmonics leave is no more than noise, window by window
// and as a whole. Everything before stays as it was read. The replacement is linear in the readings, so draws of noise
// go through it as the measured readings do. Harmonics are known at any instant: they are given so densely that a
// spline through them is exact, however few readings there were.
#pragma once

#include <Eigen/Core>

#include "core/verify/verification_stretch.hpp"

namespace dwell {

class SteadyTable {
 public:
  // readings: of the table, less their mean; sigma: of one reading; omega, rad/s; harmonics carried. Allocates.
  SteadyTable(const ChannelReadings& readings, double sigma, double omega, int harmonics);

  // The number of the first reading that is replaced; as many as there are: none is.
  [[nodiscard]] Eigen::Index from() const noexcept { return from_; }
  // Where the table's motion is given: the readings before from() as stamped, then more of them.
  [[nodiscard]] const Instants& instants() const noexcept { return instants_; }
  // One row per series: of one column per reading one column per instant. O(rows · instants · harmonics).
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& series) const;

 private:
  Eigen::Index from_;
  Instants instants_;
  Eigen::MatrixXd fit_, dense_;  // coefficients by the readings that are replaced; the motion by coefficients
};

}  // namespace dwell
