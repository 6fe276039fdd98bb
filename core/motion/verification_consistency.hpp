// Whether the statistics leave anything unexplained: two tests of what is left of predicted minus measured once every
// known source of error has taken what it can, each source within its prior N(0, u²).
//
//   χ²         reduced: weighted squares left, the sources' own included, over what noise alone leaves
//   whiteness  Q = Σ_channels N Σ_{l <= 10} ρ_l²  (Box and Pierce 1970), ρ_l the correlation of what is left at lag l
//
// The table's noise comes through the chain, so that what is left is not white even of a right model. Both tests are
// therefore held against draws of all noise and of all sources, not against tables.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace dwell {

struct Consistency {
  double chi2 = 0.0;    // over its mean of the draws
  double p_chi2 = 1.0;  // probability of as much by chance
  double p_white = 1.0;
  Eigen::VectorXd left;  // of the weighted error, the sources taken out
  // Of both tests (Bonferroni).
  [[nodiscard]] double p() const;
};

// A false alarm in a hundred rigs.
inline constexpr double kLeastP = 0.01;

class SourceFit {
 public:
  // sources: weighted error by one standard deviation of each source, a column each. O(rows · sources²).
  explicit SourceFit(Eigen::MatrixXd sources);
  // What the sources cannot explain of that weighted error.
  [[nodiscard]] Eigen::VectorXd left(const Eigen::VectorXd& error) const;
  // Σ left² + Σ z², z the sources' amplitudes: what χ² is of.
  [[nodiscard]] double chi2(const Eigen::VectorXd& error) const;
  // Of the sources, by what the error is best explained within their priors.
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
