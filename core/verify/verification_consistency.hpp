// Does predicted minus measured show more than noise and the stated sources of error? The sources are fitted to it
// first, each within its prior N(0, u²). Two tests then judge the residuals:
//
//   χ²         the weighted squares of the residuals and of the sources, over their mean in the draws
//   whiteness  Q = Σ_channels N Σ_{l <= 10} ρ_l²  (Box and Pierce 1970), ρ_l the residuals' correlation at lag l
//
// The table's noise passes through the chain, so even a right model leaves residuals that are not white. So both
// statistics are compared with draws of all noise and all sources, not with tables of χ².
#pragma once

#include <Eigen/Core>
#include <vector>

namespace dwell {

struct Consistency {
  double chi2 = 0.0;    // over its mean of the draws
  double p_chi2 = 1.0;  // probability of such a value by chance
  double p_white = 1.0;
  Eigen::VectorXd left;  // the weighted error without the sources' part
  // Probability of both tests together (Bonferroni).
  [[nodiscard]] double p() const;
};

// A false alarm in a hundred rigs.
inline constexpr double kLeastP = 0.01;

class SourceFit {
 public:
  // sources: weighted error by one standard deviation of each source, a column each. O(rows · sources²).
  explicit SourceFit(Eigen::MatrixXd sources);
  // The residuals of a weighted error: what the sources do not explain.
  [[nodiscard]] Eigen::VectorXd left(const Eigen::VectorXd& error) const;
  // χ²: Σ left² + Σ z², z the sources' amplitudes.
  [[nodiscard]] double chi2(const Eigen::VectorXd& error) const;
  // Amplitudes of the sources, in standard deviations, that explain the error best within their priors.
  [[nodiscard]] Eigen::VectorXd amplitudes(const Eigen::VectorXd& error) const;
  [[nodiscard]] const Eigen::MatrixXd& sources() const noexcept { return sources_; }

 private:
  Eigen::MatrixXd sources_, inverse_;  // of (S'S + I)
};

// error: weighted, the channels' readings below each other; ends: behind each channel's last row. draws: weighted, with
// noise and sources drawn. freedom: readings behind the noise that the weights rest on.
[[nodiscard]] Consistency consistency_of(const SourceFit& fit, const Eigen::VectorXd& error,
                                         const std::vector<Eigen::Index>& ends, const Eigen::MatrixXd& draws,
                                         double freedom);

}  // namespace dwell
