#include "core/motion/score_test.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/motion/candidates.hpp"
#include "core/motion/element_inputs.hpp"
#include "core/motion/told_inverse.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A candidate is determined if this part of its information remains once all else is fitted. The inverse leaves out
// eigenvalues below 1e-11 of the largest, so that a smaller remainder is rounding.
constexpr double kLeft = 1e-7;

ElementSizes sizes_of(const Rig& rig, const MotionCourse& course) {
  const Index elements = rig.element_count();
  const VectorXd& theta = course.fit.at.theta;  // c_1, r_1, c_2 … first (free_parameters())
  const Pass pass =
      evaluate(course.model(rig), course.data, course.fit.at, {.derivatives = false, .keep_innovations = true});
  return {theta(Eigen::seqN(0, elements, 2)), theta(Eigen::seqN(1, elements, 2)), pass.deformation};
}

class Test {
 public:
  Test(const Rig& rig, const MotionCourse& course) : rig_(rig), course_(course), parameters_(course.parameters) {
    out_.candidates = missing_candidates(rig);
    for (const Parameter& candidate : out_.candidates) {
      const auto known = std::find_if(parameters_.begin(), parameters_.end(), [&](const Parameter& p) {
        return p.what == candidate.what && p.index == candidate.index;
      });
      columns_.push_back(known - parameters_.begin());
      if (known == parameters_.end()) parameters_.push_back(candidate);
    }
  }

  ScoreTest run() {
    evaluate_all();
    if (!std::isfinite(pass_.V)) return {};
    const std::vector<Index> fitted = fitted_unknowns();
    out_.information = left_of(fitted, prior(fitted), out_);
    const auto added = static_cast<Index>(parameters_.size() - course_.parameters.size());
    for (const Index i : fitted)
      out_.moved.push_back(i < static_cast<Index>(course_.parameters.size()) ? i : i - added);
    std::vector<Index> unstated;
    for (const Index i : fitted)
      if (std::find(columns_.begin(), columns_.end(), i) == columns_.end()) unstated.push_back(i);
    ScoreTest unused;
    out_.alone = left_of(unstated, prior(unstated), unused);
    out_.own = pass_.information.diagonal()(columns_);
    const ElementSizes elements = sizes_of(rig_, course_);
    out_.sizes.resize(out_.score.size());
    for (Index a = 0; a < out_.sizes.size(); ++a) {
      const double W = out_.information(a, a);
      out_.sizes(a) = natural_size(rig_, out_.candidates[static_cast<std::size_t>(a)], elements);
      out_.told.push_back(W > kLeft * out_.own(a) && W * out_.sizes(a) * out_.sizes(a) > 1 &&
                          std::isfinite(out_.score(a)));
    }
    return std::move(out_);
  }

 private:
  void evaluate_all() {
    MotionUnknowns at = course_.fit.at;
    at.theta.conservativeResizeLike(VectorXd::Zero(static_cast<Index>(parameters_.size())));
    std::vector<Parameter> inputs;
    std::copy_if(parameters_.begin(), parameters_.end(), std::back_inserter(inputs),
                 [](const Parameter& p) { return is_input(p.what); });
    MotionData data = course_.data;
    data.inputs = element_inputs(course_.model(rig_), course_.data, course_.fit.at, inputs);
    pass_ = evaluate(MotionModel(rig_, parameters_, course_.process), data, at, {});
  }

  // Indices, in the pass, of the fitted unknowns. An unknown that ended at its lower bound is not free and is left out.
  [[nodiscard]] std::vector<Index> fitted_unknowns() const {
    std::vector<Index> out;
    const auto own = static_cast<Index>(course_.parameters.size()), all = static_cast<Index>(parameters_.size());
    const VectorXd& lowest = course_.limits.lowest;
    for (Index i = 0; i < pass_.score.size(); ++i) {
      const bool held = i < lowest.size() && course_.fit.at.theta(i) <= lowest(i) && pass_.score(i) >= 0;
      if ((i < own && !held) || i >= all) out.push_back(i);
    }
    return out;
  }
  [[nodiscard]] VectorXd prior(const std::vector<Index>& of) const {
    VectorXd out = VectorXd::Zero(static_cast<Index>(of.size()));
    for (std::size_t i = 0; i < of.size(); ++i)
      if (of[i] < static_cast<Index>(course_.parameters.size()))
        if (const double u = parameters_[static_cast<std::size_t>(of[i])].prior_u; u > 0)
          out(static_cast<Index>(i)) = 1 / (u * u);
    return out;
  }

  // The candidates' information once `given` are fitted with these priors; their score, and how those move, into `to`.
  [[nodiscard]] MatrixXd left_of(const std::vector<Index>& given, const VectorXd& prior, ScoreTest& to) const {
    MatrixXd H = pass_.information(given, given);
    VectorXd s = pass_.score(given);
    H.diagonal() += prior;
    for (std::size_t i = 0; i < given.size(); ++i)
      if (given[i] < course_.fit.at.theta.size())
        s(static_cast<Index>(i)) += prior(static_cast<Index>(i)) * course_.fit.at.theta(given[i]);
    const ToldInverse inverse(H, std::vector<bool>(given.size(), true));
    const MatrixXd cross = pass_.information(given, columns_);
    to.response = inverse.matrix() * cross;
    to.rest = inverse.matrix() * s;
    to.score = pass_.score(columns_) - to.response.transpose() * s;
    return pass_.information(columns_, columns_) - cross.transpose() * to.response;
  }

  const Rig& rig_;
  const MotionCourse& course_;
  std::vector<Parameter> parameters_;  // fitted, then the candidates that were not
  std::vector<Index> columns_;         // of the candidates, in the pass
  Pass pass_;
  ScoreTest out_;
};

}  // namespace

double ScoreTest::correlation(Index a, Index b) const {
  return std::abs(information(a, b)) / std::sqrt(information(a, a) * information(b, b));
}

MotionUnknowns ScoreTest::maximum_with(Index a, const MotionUnknowns& at) const {
  const VectorXd step = -(rest + value(a) * response.col(a));
  MotionUnknowns out = at;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Index theta = at.theta.size(), initial = at.initial.size(), to = moved[i];
    double& unknown = to < theta             ? out.theta(to)
                      : to < theta + initial ? out.initial(to - theta)
                                             : out.bias(to - theta - initial);
    unknown += step(static_cast<Index>(i));
  }
  return out;
}

ScoreTest score_test(const Rig& rig, const MotionCourse& course) { return Test(rig, course).run(); }

}  // namespace dwell
