// The evidence for or against a model: one or several stretches of motion that its coefficients were not fitted to. The
// first is the transient before the dwell that gave the coefficients. The others are transients of other dwells, with
// some of their steady motion.
//
// The chain is linear, so each stretch is scaled to the table's amplitude in the first. All vectors here have their
// rows channel by channel, and within a channel stretch by stretch.
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
  // stretch: without a fault and with compared channels. of: the dwell whose motion it is. Cost: O(readings), and
  // drawing the noise. Allocates.
  void add(VerificationStretch stretch, const Dwell& of, const Rig& rig);
  [[nodiscard]] bool empty() const noexcept { return parts_.empty(); }
  // The channel that shows the table's motion in the first stretch. There must be one.
  [[nodiscard]] int table() const { return parts_.front().stretch.table; }

  // A channel and its rows.
  struct Rows {
    int channel = -1;
    Eigen::Index begin = 0, count = 0;
    double sigma = 0.0;    // of one reading, rms over its stretches, SI
    double freedom = 0.0;  // 2 / (relative variance of the noise expected): white noise known from as many readings
  };
  [[nodiscard]] std::vector<Rows> channels() const;
  // The row after the last one, for each channel in each stretch.
  [[nodiscard]] std::vector<Eigen::Index> ends() const;

  // The residuals_of() every stretch. with_noise: with draws of the noise; steady: may be null. Fails with the first
  // fault.
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
