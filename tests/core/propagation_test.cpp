// From sources of error to covariance and budget, on the chain of the bench in its exact steady state.
#include "core/chain/propagation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/chain/identify.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/steady_evidence.hpp"

namespace dwell {
namespace {

using Eigen::VectorXcd;
using Index = Eigen::Index;

constexpr double kOmegaOfState = 2 * M_PI * 4;

struct SteadyBench {
  Chain truth = clamped_chain();
  Rig rig = rig_of(truth, 4);
  ChainState chain = state_of(truth, rig);
  ElementStates elements{chain};

  static ChainState state_of(const Chain& truth, const Rig& rig) {
    const SteadyResponse steady = steady_response(truth, kOmegaOfState, 0.002);
    VectorXcd x(4);
    x << steady.Y[0], steady.Y[1] - steady.Y[0], steady.Y[2] - steady.Y[1], steady.F;
    return {rig, 2, kOmegaOfState, x};
  }
  [[nodiscard]] VectorXcd on_x(Complex table, Complex d1, Complex d2, Complex force) const {
    VectorXcd v(4);
    v << table, d1, d2, force;
    return v;
  }
  [[nodiscard]] ErrorSource source(const char* name, const VectorXcd& on_x,
                                   double dof = std::numeric_limits<double>::infinity()) const {
    return {.name = name, .dof = dof, .on_x = on_x, .on_Z = VectorXcd::Zero(3)};
  }
};

TEST(ElementStates, GiveStiffnessAndDampingOfTheChainThatMoves) {
  const SteadyBench bench;
  for (Index e = 0; e < 3; ++e) {
    const auto i = static_cast<std::size_t>(e);
    EXPECT_NEAR(stiffness(bench.elements.Z(e)) / bench.truth.stiffness[i], 1, 1e-11);
    EXPECT_NEAR(damping(bench.elements.Z(e), kOmegaOfState) / bench.truth.damping[i], 1, 1e-9);
  }
}

TEST(Propagation, ASourceDoesToAllCoefficientsWhatItsChangeOfXDoes) {
  const SteadyBench bench;
  const VectorXcd change = 1e-7 * bench.on_x({1, 2}, {-1, 0.5}, {0.3, -1}, {800, 200});
  Propagation propagation(bench.chain, bench.elements);
  propagation.add(bench.source("one", change));
  ASSERT_EQ(propagation.effects().size(), 1u);
  const Eigen::VectorXd& stated = propagation.effects()[0].on_coefficients;
  constexpr double kPart = 1e-4;  // central differences: off by its square, and by rounding over it
  const ElementStates above({bench.rig, 2, kOmegaOfState, bench.chain.x + kPart * change}),
      below({bench.rig, 2, kOmegaOfState, bench.chain.x - kPart * change});
  for (Index e = 0; e < 3; ++e) {
    const Complex dZ = (above.Z(e) - below.Z(e)) / (2 * kPart);
    EXPECT_NEAR(stated(2 * e), dZ.real(), 1e-4 * std::abs(dZ)) << "element " << e + 1;
    EXPECT_NEAR(stated(2 * e + 1) * kOmegaOfState, dZ.imag(), 1e-4 * std::abs(dZ)) << "element " << e + 1;
  }
  EXPECT_LT((propagation.covariance() - stated * stated.transpose()).norm(), 1e-12 * stated.squaredNorm());
  // u(d_1), per component.
  EXPECT_NEAR(propagation.deformation_u(0), std::abs(change(1)) / std::sqrt(2), 1e-15);
}

TEST(Propagation, AnErrorOfOmegaTurnsIntoDamping) {
  const SteadyBench bench;
  Propagation propagation(bench.chain, bench.elements);
  ErrorSource frequency = bench.source("frequency", VectorXcd::Zero(4));
  frequency.on_omega = 0.01 * kOmegaOfState;
  propagation.add(frequency);
  for (Index e = 0; e < 3; ++e) {
    const Eigen::VectorXd& v = propagation.effects()[0].on_coefficients;
    EXPECT_EQ(v(2 * e), 0.0);
    EXPECT_NEAR(v(2 * e + 1) / bench.truth.damping[static_cast<std::size_t>(e)], -0.01, 1e-9);
  }
}

TEST(Propagation, TheBudgetAddsSourcesOfOneNameAndBeginsWithTheLargest) {
  const SteadyBench bench;
  const VectorXcd change = 1e-7 * bench.on_x(1, 1, 1, 100);
  Propagation propagation(bench.chain, bench.elements);
  propagation.add(bench.source("small", change));
  propagation.add(bench.source("large", 2 * change));
  propagation.add(bench.source("large", 2 * change));
  const auto budget = propagation.budget(0);
  ASSERT_EQ(budget.size(), 2u);
  EXPECT_EQ(budget[0].source, "large");
  EXPECT_NEAR(budget[0].stiffness_share, 8.0 / 9, 1e-12);
  EXPECT_NEAR(budget[1].damping_share, 1.0 / 9, 1e-12);
}

// Welch and Satterthwaite: two equal variances with ν each have 2ν; one of type B beside them counts in u alone.
TEST(Propagation, DegreesOfFreedomFollowWelchAndSatterthwaite) {
  const SteadyBench bench;
  const VectorXcd change = 1e-7 * bench.on_x(1, 1, 1, 100);
  Propagation propagation(bench.chain, bench.elements);
  propagation.add(bench.source("first", change, 10));
  EXPECT_NEAR(propagation.coefficient(0, 1.0).dof, 10, 1e-9);
  propagation.add(bench.source("second", change, 10));
  EXPECT_NEAR(propagation.coefficient(0, 1.0).dof, 20, 1e-9);
  const double u = propagation.coefficient(0, 1.0).u;
  propagation.add(bench.source("stated", std::sqrt(2) * change));
  const Coefficient all = propagation.coefficient(0, 2 * u);
  EXPECT_NEAR(all.dof, 80, 1e-9);
  EXPECT_NEAR(all.u, std::sqrt(2) * u, 1e-12 * u);
  EXPECT_NEAR(all.U95 / all.u, 1.990, 1e-3);  // t_95(80)
  EXPECT_TRUE(all.significant);
  EXPECT_FALSE(propagation.coefficient(0, u).significant);
}

TEST(Propagation, OnlyASourceOfResidualsIsWidenedWhereItsElementScatters) {
  const SteadyBench bench;
  // Four channels observe Y_0, d_1, d_2 and F themselves. The second, d_1, scatters: its variance is five times what
  // its noise explains.
  std::vector<Evidence> evidence(4);
  for (std::size_t c = 0; c < 4; ++c)
    for (int i = 0; i < 12; ++i)
      evidence[c].stretches.push_back({true, std::polar((c == 1 ? std::sqrt(5.0) : 1e-3) * 1e-6, 2.0 * i), 1e-12, 0.0});
  const VectorXcd change = bench.on_x(0, 1e-6, 0, 0);
  Propagation plain(bench.chain, bench.elements), widened(bench.chain, bench.elements);
  for (Propagation* propagation : {&plain, &widened})
    propagation->set_scatter(Eigen::MatrixXcd::Identity(4, 4), evidence);
  plain.add(bench.source("scale", change));
  ErrorSource noise = bench.source("noise", change, 1000);
  noise.residual = true;
  widened.add(noise);
  // Σ χ² of twelve stretches is 2·12·5, of 22 degrees of freedom; element 1 sees the noise of all four channels.
  const Eigen::RowVectorXcd through =
      (bench.elements.force_rows.row(0) - bench.elements.Z(0) * bench.elements.deformation_rows.row(0));
  const double ratio = 2 * 12 * 5 * std::norm(through(1)) / through.squaredNorm() / 22;
  EXPECT_NEAR(widened.coefficient(0, 1.0).u / plain.coefficient(0, 1.0).u, std::sqrt(ratio), 0.02 * std::sqrt(ratio));
  EXPECT_NEAR(widened.coefficient(0, 1.0).dof, 22, 1e-9);
}

// A source that only turns phasors: nothing to first order, E[(D t²)²] = 3 D² to second.
TEST(Propagation, WhatErrorsDoToSecondOrderIsASourceOfItsOwn) {
  const SteadyBench bench;
  Propagation propagation(bench.chain, bench.elements);
  ErrorSource late = bench.source("delay", VectorXcd::Zero(4));
  late.bends_x = 1e-6 * bench.on_x(1, 1, {0, 1}, 100);
  propagation.add(late);
  EXPECT_TRUE(propagation.covariance().isZero(0));
  propagation.add_second_order();
  const VectorXcd D = propagation.on_Z(late.bends_x);
  for (Index e = 0; e < 3; ++e) {
    const auto C = propagation.covariance().block<2, 2>(2 * e, 2 * e);
    EXPECT_NEAR(C(0, 0) / (3 * D(e).real() * D(e).real()), 1, 1e-9);
    EXPECT_NEAR(C(1, 1) / (3 * std::pow(D(e).imag() / kOmegaOfState, 2)), 1, 1e-9);
    ASSERT_EQ(propagation.budget(e).size(), 1u);
    EXPECT_EQ(propagation.budget(e)[0].source, "errors to second order");
  }
}

TEST(Propagation, AnElementThatIsNotDeterminedLeavesTheOthersAlone) {
  SteadyBench bench;
  bench.chain.x(1) = 0.0;
  const ElementStates elements(bench.chain);
  Propagation propagation(bench.chain, elements);
  propagation.add(bench.source("one", 1e-7 * bench.on_x(1, 0, 1, 100)));
  propagation.add_second_order();
  EXPECT_TRUE(propagation.covariance().allFinite());
  EXPECT_GT(propagation.covariance()(4, 4), 0.0);
}

}  // namespace
}  // namespace dwell
