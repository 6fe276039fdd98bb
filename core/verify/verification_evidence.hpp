// What a model is held against: one or several stretches of motion that its coefficients were not fitted to. The first
// is the transient before the dwell that gave them; others are those of other dwells, with some of their steady motion.
//
// The chain is linear, so how far the table moved in a stretch does not matter: each stretch is scaled to the table's
// amplitude in the first. Rows of all that is told are channel by channel, and of a channel stretch by stretch.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/verify/verification_residuals.hpp"
#include "core/verify/verification_stretch.hpp"
#include "core/verify/verification_table.hpp"

namespace dwell {

class VerificationEvidence {
 public:
  // stretch: without a fault and with channels that are compared. of: the dwell whose motion it is. O(readings) and the
  // draws of noise; allocates.
  void add(VerificationStretch stretch, const Dwell& of, const Rig& rig);
  [[nodiscard]] bool empty() const noexcept { return parts_.empty(); }
  // The channel that shows the table's motion in the first stretch. There must be one.
  [[nodiscard]] int table() const { return parts_.front().stretch.table; }

  // A channel and its rows.
  struct Rows {
    int channel = -1;
    Eigen::Index begin = 0, count = 0;
    double sigma = 0.0;    // of one reading, rms over its stretches, SI
    double freedom = 0.0;  // readings behind sigma
  };
  [[nodiscard]] std::vector<Rows> channels() const;
  // Behind the rows of each channel in each stretch.
  [[nodiscard]] std::vector<Eigen::Index> ends() const;

  // As residuals_of() each stretch. with_noise: with draws of it; steady: may be null. The first fault is told.
  [[nodiscard]] Residuals residuals(const Assumption& assumption, Knots knots = Knots::all, bool with_noise = false,
                                    const SteadyRatio* steady = nullptr) const;

 private:
  struct Part {
    VerificationStretch stretch;
    SteadyTable table;
    NoiseDraws draws;
    double scale;                                         // of its readings, to the amplitude of the first
    std::vector<double> freedom;                          // per channel of the rig
    [[nodiscard]] Eigen::Index count(int channel) const;  // of the rows of a channel; 0: it is not compared
  };
  [[nodiscard]] std::vector<int> compared() const;  // in any stretch, ascending

  std::vector<Part> parts_;
  double amplitude_ = 0.0;  // of the table in the first
};

}  // namespace dwell
