// Keeps the noise of the table's readings out of the virtual test. Where the table moves steadily, its readings are
// replaced by the harmonics of the drive that fit them best. Otherwise a lightly damped chain would respond to the
// noise as to a motion: at Q = 130 and twelve readings a period with eight times the noise.
//
// The steady part is the longest stretch up to the end whose residuals from the harmonics are no larger than noise,
// window by window and as a whole. Readings before it stay as they are. The replacement is linear in the readings, so
// draws of noise go through it as the measured readings do. The harmonics are sampled so densely that a spline through
// them is exact, however few readings there were.
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
  // The instants of the table's motion: the readings before from() as stamped, then the dense ones.
  [[nodiscard]] const Instants& instants() const noexcept { return instants_; }
  // One row per series: of one column per reading one column per instant. O(rows · instants · harmonics).
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& series) const;

 private:
  Eigen::Index from_;
  Instants instants_;
  Eigen::MatrixXd fit_, dense_;  // coefficients by the readings that are replaced; the motion by coefficients
};

}  // namespace dwell
