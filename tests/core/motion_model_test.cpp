#include "core/motion/motion_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <complex>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/model/propagator.hpp"
#include "core/motion/interval_steps.hpp"
#include "core/rig/transducer.hpp"
#include "tests/core/motion_case.hpp"

namespace dwell {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<Parameter> all_parameters(const Rig& rig) {
  std::vector<Parameter> parameters = free_parameters(rig, 1);
  const std::vector<Parameter> stated = stated_parameters(rig);
  parameters.insert(parameters.end(), stated.begin(), stated.end());
  for (int k = 0; k < rig.mass_count(); ++k) {
    parameters.push_back({Unknown::ground_stiffness, k});
    parameters.push_back({Unknown::ground_damping, k});
  }
  for (int pair = 0; pair < static_cast<int>(apart(rig.mass_count()).size()); ++pair)
    parameters.push_back({Unknown::side_stiffness, pair});
  return parameters;
}

TEST(MotionModel, MovesTheMassesAsThePropagatorDoesOverAnyInterval) {
  std::mt19937_64 rng(3);
  for (const Boundary boundary : {Boundary::free, Boundary::clamped})
    for (int n = 1; n <= 4; ++n) {
      const Chain chain = random_chain(rng, n, boundary, 4.0);
      const Rig rig = rig_of(chain, 4.0);
      const MotionModel model(rig, free_parameters(rig, 1));
      const std::vector<double> sigma(rig.channels.size(), 1.0);
      IntervalSteps steps(model.at(theta_of(model.parameters(), chain, sigma, 0.0)));
      Propagator propagator(chain);
      for (const double dt : {1e-7, 3e-4, 0.0021, 0.05, 1.3}) {
        VectorXd state = VectorXd::Random(2 * n);  // y and y', the table held at 0
        ChainMotion before, after;
        before.y.assign(state.data(), state.data() + n);
        before.velocity.assign(state.data() + n, state.data() + 2 * n);
        for (auto* table : {&before.y, &before.velocity, &before.acceleration}) table->insert(table->begin(), 0.0);
        propagator.apply(dt, state);
        after = before;
        std::copy(state.data(), state.data() + n, after.y.begin() + 1);
        std::copy(state.data() + n, state.data() + 2 * n, after.velocity.begin() + 1);
        const VectorXd moved = steps.over(to_ns(dt)).F() * state_of(model, before);
        EXPECT_LT((moved - state_of(model, after)).norm(), 1e-9 * state_of(model, before).norm()) << n << " " << dt;
      }
    }
}

TEST(MotionModel, ReadsWhatEveryTransducerShows) {
  Rig rig = rig_of_all_kinds();
  for (Channel& channel : rig.channels) channel.lowpass.kind = channel.highpass.kind = FilterKind::none;
  rig.channels[1].measures = Quantity::acceleration;  // relative to the table
  rig.channels[3].force_on_mass = true;
  const Chain chain = clamped_chain();
  const MotionModel model(rig, free_parameters(rig, 1));
  const LinearModel linear = model.at(theta_of(model.parameters(), chain, {1, 1, 1, 1, 1}, 0.0));
  DrivenChain driven(chain, {4.0, 0.005, 0.001, 0.2}, DrivenChain::Start::rest);
  for (const double t : {0.0, 0.1, 0.7, 2.0}) {
    const ChainMotion& motion = driven.at(t);
    const VectorXd shown = linear.C * state_of(model, motion);
    for (int c = 0; c < 5; ++c)
      EXPECT_NEAR(shown(c), exact_reading(rig, motion, c), 1e-11 + 1e-11 * std::abs(shown(c)));
  }
}

TEST(MotionModel, FiltersAsTheTransducersFrequencyResponseSays) {
  for (const FilterKind kind : {FilterKind::butterworth, FilterKind::bessel, FilterKind::rc})
    for (int order = 1; order <= 8; ++order)
      for (const bool high : {false, true}) {
        Rig rig = rig_of(free_chain(), 4.0);
        (high ? rig.channels[0].highpass : rig.channels[0].lowpass) = {kind, order, high ? 0.7 : 40.0};
        const MotionModel model(rig, free_parameters(rig, 1));
        const LinearModel linear = model.at(theta_of(model.parameters(), free_chain(), {1, 1, 1}, 0.0));
        const int from = model.states() - order;
        const std::complex<double> s{0.0, kTwoPi * 6.0};
        // Driven by the table's displacement alone, as a phasor of 1.
        const Eigen::MatrixXcd own = s * MatrixXd::Identity(order, order) -
                                     linear.A.bottomRightCorner(order, order).cast<std::complex<double>>();
        const Eigen::VectorXcd states =
            own.partialPivLu().solve(linear.A.col(0).tail(order).cast<std::complex<double>>());
        const std::complex<double> H = linear.C(0, 0) + (linear.C.row(0).tail(order) * states)(0);
        const std::complex<double> expected =
            filter_response(high ? rig.channels[0].highpass : rig.channels[0].lowpass, high, s);
        EXPECT_LT(std::abs(H - expected), 1e-9) << static_cast<int>(kind) << " order " << order << " from " << from;
      }
}

TEST(MotionModel, DifferentiatesItsMatricesByEveryUnknown) {
  const Rig rig = rig_of_all_kinds();
  const MotionModel model(rig, all_parameters(rig));
  VectorXd theta = theta_of(model.parameters(), clamped_chain(), {1, 1, 1, 1, 1}, 0.0);
  const LinearModel here = model.at(theta);
  for (Eigen::Index a = 0; a < theta.size(); ++a) {
    const Parameter& p = model.parameters()[static_cast<std::size_t>(a)];
    const double h = p.prior_u > 0 ? 0.01 * p.prior_u : 1e-4 * std::max(1.0, std::abs(theta(a)));
    VectorXd up = theta, down = theta;
    up(a) += h;
    down(a) -= h;
    const LinearModel above = model.at(up), below = model.at(down);
    const MatrixXd dA = (above.A - below.A) / (2 * h), dC = (above.C - below.C) / (2 * h);
    const MatrixXd& A = here.dA[static_cast<std::size_t>(a)];
    const MatrixXd& C = here.dC[static_cast<std::size_t>(a)];
    const std::string name = name_of(rig, p);
    EXPECT_LT((dA - (A.size() > 0 ? A : MatrixXd::Zero(dA.rows(), dA.cols()))).norm(),
              1e-6 * (dA.norm() + here.A.norm() * 1e-4))
        << name;
    EXPECT_LT((dC - (C.size() > 0 ? C : MatrixXd::Zero(dC.rows(), dC.cols()))).norm(),
              1e-6 * (dC.norm() + here.C.norm() * 1e-4))
        << name;
  }
}

// Friction in an element acts as a stiffness would if the deformation were one: on both masses and in what is read.
TEST(MotionModel, TakesAForceInAnElementAsAnInput) {
  const Rig rig = rig_of(clamped_chain(), 4.0);
  std::vector<Parameter> parameters = free_parameters(rig, 1);
  parameters.push_back({Unknown::friction, 1});
  parameters.push_back({Unknown::friction, 2});
  const MotionModel model(rig, parameters);
  const LinearModel linear = model.at(theta_of(parameters, clamped_chain(), {1, 1, 1, 1}, 0.0));
  ASSERT_EQ(linear.inputs,
            (std::vector<int>{static_cast<int>(parameters.size()) - 2, static_cast<int>(parameters.size()) - 1}));
  const double omega0 = kTwoPi * 4.0, m1 = rig.masses[0], m2 = rig.masses[1];
  VectorXd between = VectorXd::Zero(model.states()), beyond = between;
  const int rates = model.table_states() + 2;
  between(rates) = 1 / m1 / omega0;
  between(rates + 1) = -(1 / m1 + 1 / m2) / omega0;
  beyond(rates + 1) = 1 / m2 / omega0;
  EXPECT_LT((linear.B.col(0) - between).norm(), 1e-12 * between.norm());
  EXPECT_LT((linear.B.col(1) - beyond).norm(), 1e-12 * beyond.norm());
  EXPECT_EQ(linear.D.col(0), VectorXd::Zero(4));
  EXPECT_EQ(linear.D(3, 1), -1.0);  // the element is stretched, the ground is pulled
}

TEST(IntervalSteps, GiveTheNoiseOfAnIntervalAsVanLoanDoes) {
  const Rig rig = rig_of_all_kinds();
  const MotionModel model(rig, all_parameters(rig));
  const LinearModel linear = model.at(theta_of(model.parameters(), clamped_chain(), {1, 1, 1, 1, 1}, 0.0));
  IntervalSteps steps(linear);
  const Eigen::Index m = model.states();
  for (const double dt : {1e-4, 0.002, 0.03}) {
    MatrixXd block = MatrixXd::Zero(2 * m, 2 * m);
    block.topLeftCorner(m, m) = -linear.A;
    block(linear.noise_state, m + linear.noise_state) = 1.0;
    block.bottomRightCorner(m, m) = linear.A.transpose();
    const MatrixXd exponential = (block * dt).exp();
    const MatrixXd F = exponential.bottomRightCorner(m, m).transpose();
    const MatrixXd Q = F * exponential.topRightCorner(m, m);
    EXPECT_LT((steps.over(to_ns(dt)).F() - F).norm(), 1e-11 * F.norm()) << dt;
    EXPECT_LT((steps.over(to_ns(dt)).Q() - Q).norm(), 1e-9 * Q.norm()) << dt;
  }
}

TEST(IntervalSteps, DifferentiateWhatTheyGive) {
  const Rig rig = rig_of_all_kinds();
  const MotionModel model(rig, all_parameters(rig));
  const VectorXd theta = theta_of(model.parameters(), clamped_chain(), {1, 1, 1, 1, 1}, 0.0);
  IntervalSteps here(model.at(theta));
  const std::int64_t dt_ns = 31'000'000;  // long enough to be doubled
  const Step step = here.over(dt_ns);
  for (Eigen::Index a = 0; a < theta.size(); ++a) {
    const int d = here.derivative_of()[static_cast<std::size_t>(a)];
    if (d < 0) continue;
    const double u = model.parameters()[static_cast<std::size_t>(a)].prior_u;
    const double h = u > 0 ? 0.1 * u : theta(a) != 0 ? 1e-4 * std::abs(theta(a)) : 1.0;
    VectorXd up = theta, down = theta;
    up(a) += h;
    down(a) -= h;
    IntervalSteps above(model.at(up)), below(model.at(down));
    const MatrixXd dF = (above.over(dt_ns).F() - below.over(dt_ns).F()) / (2 * h);
    const MatrixXd dQ = (above.over(dt_ns).Q() - below.over(dt_ns).Q()) / (2 * h);
    EXPECT_LT((step.dF(d) - dF).norm(), 1e-5 * (dF.norm() + 1e-9)) << a;
    EXPECT_LT((step.dQ(d) - dQ).norm(), 1e-5 * (dQ.norm() + 1e-9)) << a;
  }
}

}  // namespace
}  // namespace dwell
