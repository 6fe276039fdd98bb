// Would one more unknown explain more? Rao's score test at a maximum of the likelihood, of all candidates in one pass.
//
// With s the score and I the information of (ξ, x), ξ all that was fitted and x the candidates, x = 0:
//
//   W = I_xx - I_xξ H⁻¹ I_ξx,   s̃ = s_x - I_xξ H⁻¹ s_ξ,   H = I_ξξ + diag 1/u²
//   gain of candidate a = ½ s̃_a² / W_aa,   its value = -s̃_a / W_aa,   correlation of two = W_ab / √(W_aa W_bb)
//
// A candidate that was fitted with a prior is tested as a second parameter of the same effect without one: then 1/W is
// the variance of the readings' own value plus u², and 2 gain the squared distance of that value from what is stated,
// over its variance.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/motion_course.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct ScoreTest {
  std::vector<Parameter> candidates;
  std::vector<bool> told;       // whether the readings determine it at all, with all else fitted
  Eigen::VectorXd score;        // s̃
  Eigen::MatrixXd information;  // W
  // W of the readings alone, as if the rig file stated nothing: without the priors. A null direction of it is a
  // combination of candidates that no reading determines. In the candidates' units, as W.
  Eigen::MatrixXd alone;
  Eigen::VectorXd own;    // information of each candidate with all else known
  Eigen::VectorXd sizes;  // natural_size() of each candidate
  // H⁻¹ I_ξx and H⁻¹ s_ξ, and which of (θ, initial, bias) each row moves.
  Eigen::MatrixXd response;
  Eigen::VectorXd rest;
  std::vector<Eigen::Index> moved;

  [[nodiscard]] double gain(Eigen::Index a) const { return 0.5 * score(a) * score(a) / information(a, a); }
  [[nodiscard]] double value(Eigen::Index a) const { return -score(a) / information(a, a); }
  // Where the maximum lies with candidate a, to first order: `at`, the fit, moved, without a itself.
  [[nodiscard]] MotionUnknowns maximum_with(Eigen::Index a, const MotionUnknowns& at) const;
  [[nodiscard]] double correlation(Eigen::Index a, Eigen::Index b) const;  // absolute
};

// course.fit: converged. One pass without derivatives and one with. Allocates; thread-safe.
[[nodiscard]] ScoreTest score_test(const Rig& rig, const MotionCourse& course);

}  // namespace dwell
