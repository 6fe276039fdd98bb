#include "core/motion/likelihood.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "core/motion/interval_steps.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<Parameter> every_parameter(const Rig& rig, int stretches) {
  std::vector<Parameter> parameters = free_parameters(rig, stretches);
  const std::vector<Parameter> stated = stated_parameters(rig);
  parameters.insert(parameters.end(), stated.begin(), stated.end());
  for (int k = 0; k < rig.mass_count(); ++k) {
    parameters.push_back({Unknown::ground_stiffness, k});
    parameters.push_back({Unknown::ground_damping, k});
  }
  for (int e = 0; e < rig.element_count(); ++e) parameters.push_back({Unknown::friction, e});
  return parameters;
}

struct Setting {
  explicit Setting(const Rig& the_rig, int stretches = 1) : model(the_rig, every_parameter(the_rig, stretches)) {}
  MotionModel model;
  MotionData data;
  MotionUnknowns at;
};

// Irregular readings of a rig with all kinds of transducers; the values need not be a motion.
Setting irregular(int readings, int stretches = 1) {
  Setting s(rig_of_all_kinds(), stretches);
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  const std::vector<double> sigma{1e-4, 2e-4, 0.3, 4.0, 2e-3};
  std::int64_t t = 0;
  for (int i = 0; i < readings; ++i) {
    const int c = i % 5;
    if (i % 3 != 0) t += static_cast<std::int64_t>(4e6 * uniform(rng));
    const double size = c == 2 ? 3.0 : c == 3 ? 40.0 : c == 4 ? 0.1 : 0.005;
    s.data.readings.push_back({t, c, size * (std::sin(1e-9 * 25.0 * static_cast<double>(t) + c) + 0.2 * normal(rng))});
  }
  s.data.stretches = {{0, 0}, {t / 2, 1}, {2 * t / 3, 0}};
  s.data.stretches.resize(stretches == 1 ? 1 : 3);
  s.at.theta = theta_of(s.model.parameters(), clamped_chain(), sigma, std::log(1e-4));
  for (Index a = 0; a < s.at.theta.size(); ++a)
    if (const double u = s.model.parameters()[static_cast<std::size_t>(a)].prior_u; u > 0) s.at.theta(a) = 0.3 * u;
  for (int e = 0; e < s.model.rig().element_count(); ++e) {
    MotionInput input;
    for (int i = 0; i < readings; ++i) {
      input.mean.push_back(normal(rng));
      input.now.push_back(normal(rng));
    }
    s.data.inputs.push_back(input);
  }
  s.at.initial = 1e-3 * VectorXd::Random(s.model.states());
  s.at.bias = 1e-4 * VectorXd::Random(5);
  return s;
}

TEST(Likelihood, IsThatOfTheJointNormalDistribution) {
  const Setting s = irregular(40);
  const LinearModel linear = s.model.at(s.at.theta);
  IntervalSteps steps(linear);
  const Index N = static_cast<Index>(s.data.readings.size()), m = s.model.states();
  const double q = 1e-4;
  VectorXd residual(N);
  MatrixXd covariance = MatrixXd::Zero(N, N);
  for (Index i = 0; i < N; ++i) {
    const MotionReading& one = s.data.readings[static_cast<std::size_t>(i)];
    const Step to = steps.over(one.t_ns);
    residual(i) = one.value - (linear.C.row(one.channel) * to.F() * s.at.initial)(0) - s.at.bias(one.channel);
    const MatrixXd P = q * to.Q();
    for (Index j = i; j < N; ++j) {
      const MotionReading& other = s.data.readings[static_cast<std::size_t>(j)];
      const MatrixXd F = steps.over(other.t_ns - one.t_ns).F();
      covariance(i, j) = covariance(j, i) =
          (linear.C.row(other.channel) * F * P * linear.C.row(one.channel).transpose())(0);
    }
    for (std::size_t a = 0; a < s.model.parameters().size(); ++a)
      if (const Parameter& p = s.model.parameters()[a]; p.what == Unknown::noise && p.index == one.channel)
        covariance(i, i) += std::exp(2 * s.at.theta(static_cast<Index>(a)));
  }
  const Eigen::LLT<MatrixXd> llt(covariance);
  double expected = 0.5 * residual.dot(llt.solve(residual));
  for (Index i = 0; i < N; ++i) expected += std::log(llt.matrixL()(i, i));
  const Pass pass = evaluate(s.model, s.data, s.at, {});
  EXPECT_GT(m, 7);
  EXPECT_NEAR(pass.V, expected, 1e-7 * std::abs(expected));
}

TEST(Likelihood, DifferentiatesByEveryUnknown) {
  const Setting s = irregular(150, 2);
  const Pass pass = evaluate(s.model, s.data, s.at, {});
  const Index p = s.at.theta.size(), m = s.model.states();
  const auto V_at = [&](Index i, double step) {
    MotionUnknowns moved = s.at;
    (i < p ? moved.theta(i) : i < p + m ? moved.initial(i - p) : moved.bias(i - p - m)) += step;
    return evaluate(s.model, s.data, moved, {.derivatives = false}).V;
  };
  for (Index i = 0; i < pass.score.size(); ++i) {
    const double h = 0.01 / std::sqrt(pass.information(i, i));
    const double slope = (8 * (V_at(i, h) - V_at(i, -h)) - (V_at(i, 2 * h) - V_at(i, -2 * h))) / (12 * h);
    const std::string name = i < p ? name_of(s.model.rig(), s.model.parameters()[static_cast<std::size_t>(i)])
                                   : "state or bias " + std::to_string(i - p);
    EXPECT_NEAR(pass.score(i), slope, 1e-4 * std::abs(slope) + 1e-3 * std::sqrt(pass.information(i, i))) << name;
  }
}

// Rigs as drawn by their own model: what the score scatters by is the information.
TEST(Likelihood, ScattersItsScoreByTheInformation) {
  const Rig rig = rig_of({Boundary::free, {10.0}, {6000.0}, {20.0}}, 4.0);
  const MotionModel model(rig, free_parameters(rig, 1));
  const Chain chain{Boundary::free, {10.0}, {6000.0}, {20.0}};
  MotionUnknowns at{theta_of(model.parameters(), chain, {1e-5, 1e-5}, std::log(1e-5)), VectorXd::Zero(model.states()),
                    VectorXd::Zero(2)};
  const LinearModel linear = model.at(at.theta);
  IntervalSteps steps(linear);
  const Step step = steps.over(5'000'000);
  const Eigen::LDLT<MatrixXd> ldlt(1e-5 * step.Q());
  const MatrixXd root = ldlt.transpositionsP().transpose() * MatrixXd(ldlt.matrixL()) *
                        ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  std::mt19937_64 rng(8);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 200;
  VectorXd squares = VectorXd::Zero(5), expected = squares;
  for (int draw = 0; draw < kDraws; ++draw) {
    MotionData data;
    VectorXd x = VectorXd::Zero(model.states());
    for (int i = 0; i < 200; ++i) {
      for (int c = 0; c < 2; ++c)
        data.readings.push_back({i * 5'000'000LL, c, linear.C.row(c).dot(x) + 1e-5 * normal(rng)});
      VectorXd w(x.size());
      for (double& one : w) one = normal(rng);
      x = step.F() * x + root * w;
    }
    const Pass pass = evaluate(model, data, at, {});
    expected += pass.information.diagonal().head(5);
    squares += pass.score.head(5).cwiseAbs2();
  }
  for (int a = 0; a < 5; ++a) EXPECT_NEAR(squares(a) / expected(a), 1.0, 0.35) << a;  // 3.5 times √(2/200)
}

TEST(Likelihood, IsTheSameWithGainsThatAreUsedAgain) {
  const Rig rig = rig_of(clamped_chain(), 4.0);
  DrivenChain driven(clamped_chain(), {4.0, 0.005, 0.0, 0.0}, DrivenChain::Start::rest);
  MotionData data = readings_of(rig, driven, 0.0, 6.0, 300.0, {1e-5, 1e-5, 1e-5, 0.1}, 3, 2e-4);
  const MotionModel model(rig, free_parameters(rig, 1));
  MotionUnknowns at{theta_of(model.parameters(), clamped_chain(), {1e-5, 1e-5, 1e-5, 0.1}, std::log(1e-3)),
                    VectorXd::Zero(model.states()), VectorXd::Zero(4)};
  const Pass steady = evaluate(model, data, at, {});
  for (std::size_t i = 1; i + 1 < data.readings.size(); i += 4)
    data.readings[i].t_ns += 3 - static_cast<std::int64_t>(i / 4 % 7);  // no pattern: nothing is used again
  const Pass anew = evaluate(model, data, at, {});
  EXPECT_NEAR(steady.V, anew.V, 0.01);  // 3 ns at 0.1 m/s are 3e-5 σ, 7200 readings
  EXPECT_LT((steady.information - anew.information).norm(), 1e-5 * anew.information.norm());
}

// Sums are gathered in batches of 64 readings.
TEST(Likelihood, AsManyReadingsAsFillABatchAreAsGoodAsAnyOther) {
  for (const int readings : {63, 64, 65, 128}) {
    const Setting s = irregular(readings);
    const Pass pass = evaluate(s.model, s.data, s.at, {});
    EXPECT_TRUE(std::isfinite(pass.V)) << readings;
    EXPECT_TRUE(pass.information.allFinite()) << readings;
  }
}

}  // namespace
}  // namespace dwell
