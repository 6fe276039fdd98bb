#include "core/motion/interval_steps.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kLongest = 0.5;  // α t up to which …
constexpr int kTerms = 18;        // … the first term left off is below 1e-22 in F; in Q, where α counts twice, 1e-17
constexpr std::size_t kKnown = 256;  // intervals remembered; stamps without a pattern would fill the memory

double norm1(const MatrixXd& matrix) { return matrix.cwiseAbs().colwise().sum().maxCoeff(); }

// α of the header, 1/s.
double growth_of(const MatrixXd& A) {
  const MatrixXd A2 = A * A, A4 = A2 * A2;
  return std::max(std::pow(norm1(A4), 0.25), std::pow(norm1(A4 * A), 0.2));
}

}  // namespace

IntervalSteps::IntervalSteps(const LinearModel& model) {
  const Index m = model.A.rows();
  int derivatives = 0;
  for (const MatrixXd& dA : model.dA) derivative_of_.push_back(dA.size() > 0 ? derivatives++ : -1);
  longest_s_ = kLongest / std::max(growth_of(model.A), 1e-300);

  Step term{MatrixXd::Zero(m, 2 * m * (1 + derivatives))};
  term.all.leftCols(m).setIdentity();
  terms_.push_back(term.all);
  for (int k = 1; k <= kTerms; ++k) {
    const Step before = term;
    const auto product = [&](const MatrixXd& A, const auto& F) -> MatrixXd { return A * F / k; };
    const auto both = [&](const MatrixXd& A, const auto& Q) -> MatrixXd {
      const MatrixXd half = A * Q;
      return (half + half.transpose()) / k;
    };
    term.all.leftCols(m) = product(model.A, before.F());
    term.all.middleCols(m, m) = both(model.A, before.Q());
    for (std::size_t a = 0; a < model.dA.size(); ++a) {
      const int d = derivative_of_[a];
      if (d < 0) continue;
      term.all.middleCols(2 * (d + 1) * m, m) = product(model.dA[a], before.F()) + product(model.A, before.dF(d));
      term.all.middleCols((2 * d + 3) * m, m) = both(model.dA[a], before.Q()) + both(model.A, before.dQ(d));
    }
    if (k == 1) term.all(model.noise_state, m + model.noise_state) = 1.0;
    terms_.push_back(term.all);
  }
}

const Step& IntervalSteps::over(std::int64_t dt_ns) {
  if (const auto it = known_.find(dt_ns); it != known_.end()) return it->second;
  Step& into = known_.size() < kKnown ? known_[dt_ns] : other_;
  fill(1e-9 * static_cast<double>(dt_ns), into);
  return into;
}

void IntervalSteps::fill(double dt_s, Step& out) const {
  int doublings = 0;
  while (dt_s > longest_s_) {
    dt_s *= 0.5;
    ++doublings;
  }
  out.all = terms_.back();
  for (std::size_t k = terms_.size() - 1; k-- > 0;) out.all = out.all * dt_s + terms_[k];
  while (doublings-- > 0) double_interval(out);
}

// F(2t) = F F,  Q(2t) = F Q F' + Q.
void IntervalSteps::double_interval(Step& step) const {
  const Index m = step.all.rows(), derivatives = step.all.cols() / (2 * m) - 1;
  const MatrixXd F = step.F(), Q = step.Q(), FQ = F * Q;
  for (Index d = 0; d < derivatives; ++d) {
    const MatrixXd dF = step.dF(d), dQ = step.dQ(d), half = dF * FQ.transpose();
    step.all.middleCols(2 * (d + 1) * m, m) = dF * F + F * dF;
    step.all.middleCols((2 * d + 3) * m, m) = half + half.transpose() + F * dQ * F.transpose() + dQ;
  }
  step.all.leftCols(m) = F * F;
  step.all.middleCols(m, m) = FQ * F.transpose() + Q;
}

}  // namespace dwell
