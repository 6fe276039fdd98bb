// The equations of the chain, held against natural oscillations that are known exactly.
#include "core/chain/mode_residual.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/base/complex.hpp"
#include "core/chain/chain_state.hpp"
#include "core/chain/mode_check.hpp"
#include "core/model/forward.hpp"
#include "core/model/natural_modes.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

using Eigen::Index;

constexpr double kHz = 4.0, kSigma = 3e-6;  // of an amplitude of one

Chain any_chain(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const int n = 1 + static_cast<int>(4 * unit(random));
  Chain chain{unit(random) < 0.5 ? Boundary::free : Boundary::clamped, {}, {}, {}};
  for (int k = 0; k < n; ++k) chain.masses.push_back(std::exp(2 * unit(random)));
  for (int e = 0; e < chain.element_count(); ++e) {
    chain.stiffness.push_back(1e4 * std::exp(2 * unit(random)));
    chain.damping.push_back(1e-3 * chain.stiffness.back() * unit(random));
  }
  return chain;
}

// What the transducers read of a motion exp(st) in which the places 0 … n move by y.
Eigen::VectorXcd readings(const Rig& rig, const Chain& truth, const std::vector<Complex>& y, Complex s) {
  Eigen::VectorXcd out(static_cast<Index>(rig.channels.size()));
  for (Index c = 0; c < out.size(); ++c) {
    const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
    const Complex seen = channel.measures == Quantity::force
                             ? (truth.stiffness.back() + s * truth.damping.back()) * y.back()
                             : y[static_cast<std::size_t>(channel.at)];
    out(c) = seen / as_observed(rig, static_cast<int>(c), 1.0, s);
  }
  return out;
}

// Readings of a steady motion, evaluated as `rig` believes.
ElementsResult identified_from(const Rig& rig, const Eigen::VectorXcd& X) {
  const double omega = 2 * M_PI * kHz;
  std::vector<Evidence> evidence(rig.channels.size());
  for (std::size_t c = 0; c < evidence.size(); ++c) {
    evidence[c].usable = true;
    evidence[c].X[0] = X(static_cast<Index>(c));
    evidence[c].covariance = std::pow(kSigma * std::abs(evidence[c].X[0]), 2) * Eigen::Matrix2d::Identity();
    evidence[c].dof = 1e6;
  }
  const Gain gain = solve_observation(observation_matrix(rig), observation_weights(rig, evidence, omega));
  return estimate_elements(rig, gain, evidence, {omega, 0.0, 0.0});
}

// The steady motion of `truth` as `read` reads it, evaluated as `rig` believes.
ElementsResult identified_by(const Rig& rig, const Rig& read, const Chain& truth) {
  const double omega = 2 * M_PI * kHz;
  return identified_from(rig, readings(read, truth, steady_response(truth, omega, 0.002).Y, {0.0, omega}));
}

SeenMode seen_as(Complex pole, const Eigen::VectorXcd& amplitude) {
  SeenMode mode;
  mode.pole = pole;
  mode.amplitude = amplitude;
  const Index size = 2 * mode.amplitude.size() + 2;
  mode.covariance.setZero(size, size);
  for (Index c = 0; c < mode.amplitude.size(); ++c)
    mode.covariance.block<2, 2>(2 * c, 2 * c) =
        std::pow(kSigma * std::abs(mode.amplitude(c)), 2) * Eigen::Matrix2d::Identity();
  mode.covariance.bottomRightCorner<2, 2>() = std::pow(kSigma * std::abs(mode.pole), 2) * Eigen::Matrix2d::Identity();
  mode.fitted.assign(static_cast<std::size_t>(mode.amplitude.size()), true);
  return mode;
}

// Its first natural oscillation as `read` reads it.
SeenMode mode_of(const Rig& read, const Chain& truth) {
  const NaturalMode natural = natural_modes(truth).front();
  std::vector<Complex> y{0.0};
  for (const Complex at : natural.shape) y.push_back(at);
  return seen_as(natural.pole, readings(read, truth, y, natural.pole));
}

// A chain with a spring or a damper that its file does not have, by its matrices: places 1 … n, the table held.
struct Connected {
  Chain chain;
  int from, to;  // kGround: the ground
  double spring, damper;

  // The force that holds the places 1 … n in a motion exp(st), by their motions; and that which a table that moves by
  // one exerts on them.
  [[nodiscard]] Eigen::MatrixXcd dynamic(Complex s, Eigen::VectorXcd* of_table = nullptr) const {
    const int n = chain.mass_count();
    Eigen::MatrixXcd D = Eigen::MatrixXcd::Zero(n + 1, n + 1);
    const auto connect = [&](int a, int b, Complex Z) {
      D(a, a) += Z;
      if (b == kGround) return;
      D(b, b) += Z;
      D(a, b) -= Z;
      D(b, a) -= Z;
    };
    for (int k = 1; k <= chain.element_count(); ++k) {
      const auto e = static_cast<std::size_t>(k - 1);
      const Complex Z = chain.stiffness[e] + s * chain.damping[e];
      k <= n ? connect(k - 1, k, Z) : connect(n, kGround, Z);
    }
    connect(from, to, spring + s * damper);
    for (int k = 1; k <= n; ++k) D(k, k) += s * s * chain.masses[static_cast<std::size_t>(k - 1)];
    if (of_table) *of_table = -D.col(0).tail(n);
    return D.bottomRightCorner(n, n);
  }
  [[nodiscard]] std::vector<Complex> steady(double omega) const {
    Eigen::VectorXcd of_table;
    const Eigen::MatrixXcd D = dynamic({0.0, omega}, &of_table);
    const Eigen::VectorXcd Y = D.partialPivLu().solve(0.002 * of_table);
    std::vector<Complex> y{0.002};
    for (const Complex at : Y) y.push_back(at);
    return y;
  }
  // By Newton's steps on det D(λ) from the chain's own; the shape by an inverse iteration.
  [[nodiscard]] SeenMode mode(const Rig& read) const {
    const NaturalMode natural = natural_modes(chain).front();
    Complex pole = natural.pole;
    Eigen::VectorXcd shape = natural.shape;
    for (int step = 0; step < 20; ++step) {
      const Complex h = 1e-6 * pole;
      const Eigen::MatrixXcd slope = (dynamic(pole + h) - dynamic(pole - h)) / (2.0 * h);
      pole -= 1.0 / (dynamic(pole).partialPivLu().solve(slope)).trace();
      shape = dynamic(pole * (1.0 + 1e-12)).partialPivLu().solve(shape).normalized();
    }
    shape *= natural.shape(0) / shape(0);  // in the phase of the chain's own
    std::vector<Complex> y{0.0};
    for (const Complex at : shape) y.push_back(at);
    return seen_as(pole, readings(read, chain, y, pole));
  }
};

void expect_near(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double part) {
  ASSERT_EQ(a.size(), b.size());
  // The mass of a single one divides out.
  EXPECT_LT((a - b).norm(), part * b.norm() + 1e-12) << a.transpose() << " beside " << b.transpose();
}

TEST(ModeResidual, VanishesForTheNaturalOscillationsOfAnyChainThatIsAsItsFileSays) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    std::mt19937_64 random(seed);
    const Chain chain = any_chain(random);
    const Rig rig = rig_of(chain, kHz);
    const SeenMode mode = mode_of(rig, chain);
    const ElementsResult identified = identified_by(rig, rig, chain);
    const ModeResidual residual(rig, identified, 2 * M_PI * kHz, mode);
    ASSERT_EQ(residual.elements().size(), static_cast<std::size_t>(rig.element_count())) << seed;
    EXPECT_LT(residual.scaled_residual().norm(), 1e-9) << seed;
  }
}

// Errors of a part in 10⁵, where what is linear must hold to a thousandth.
TEST(ModeResidual, IsMovedByEachSingleFaultAsItsDerivativeSays) {
  constexpr double kSmall = 1e-5;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const Chain chain = any_chain(random);
    const Rig rig = rig_of(chain, kHz);
    Rig stated = rig, read = rig;
    stated.masses[0] *= 1 + kSmall;
    const ElementsResult of_mass = identified_by(stated, rig, chain), exact = identified_by(rig, rig, chain);
    const SeenMode exact_mode = mode_of(rig, chain);
    const double omega = 2 * M_PI * kHz;
    expect_near(ModeResidual(stated, of_mass, omega, exact_mode).scaled_residual(),
                kSmall * ModeResidual(rig, exact, omega, exact_mode).by_mass(0), 1e-3);

    // The channel of the first mass is read too early by a part of a radian.
    const double late_s = -kSmall / omega;
    read.channels[1].delay_s = late_s;
    const ElementsResult of_delay = identified_by(rig, read, chain);
    const SeenMode late_mode = mode_of(read, chain);
    expect_near(ModeResidual(rig, of_delay, omega, late_mode).scaled_residual(),
                late_s * ModeResidual(rig, exact, omega, exact_mode).by_delay(1), 1e-3);

    // The last channel, the load cell of a clamped chain, reads too much.
    const auto last = static_cast<Index>(rig.channels.size()) - 1;
    Eigen::VectorXcd X = readings(rig, chain, steady_response(chain, omega, 0.002).Y, {0.0, omega});
    constexpr double kPart = 0.1 * kSmall;
    X(last) *= 1 + kPart;
    SeenMode large = exact_mode;
    large.amplitude(last) *= 1 + kPart;
    expect_near(ModeResidual(rig, identified_from(rig, X), omega, large).scaled_residual(),
                kPart * ModeResidual(rig, exact, omega, exact_mode).by_scale(last), 2e-3);
  }
}

TEST(ModeResidual, IsMovedByEachConnectionThatTheFileDoesNotHaveAsItsDerivativeSays) {
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const Chain chain = any_chain(random);
    const Rig rig = rig_of(chain, kHz);
    const double omega = 2 * M_PI * kHz;
    const ElementsResult exact = identified_by(rig, rig, chain);
    const SeenMode exact_mode = mode_of(rig, chain);
    const ModeResidual residual(rig, exact, omega, exact_mode);
    const int n = chain.mass_count();
    for (const auto& [from, to] : {std::pair{n, static_cast<int>(kGround)}, {0, n}, {1, n}})
      for (const bool damps : {false, true}) {
        if (to != kGround && to - from < 2) continue;                        // an element of its own
        if (to == kGround && chain.boundary == Boundary::clamped) continue;  // likewise
        const double size = 1e-6 * (damps ? chain.stiffness[0] / omega : chain.stiffness[0]);
        const Connected truth{chain, from, to, damps ? 0.0 : size, damps ? size : 0.0};
        const ElementsResult of_it = identified_from(rig, readings(rig, chain, truth.steady(omega), {0.0, omega}));
        const SeenMode mode = truth.mode(rig);
        expect_near(ModeResidual(rig, of_it, omega, mode).scaled_residual().normalized(),
                    (size * residual.by_connection(from, to, damps)).normalized(), 1e-2);
        ++tried;
      }
  }
  EXPECT_GT(tried, 100);
}

// A low-pass whose corner is not known moves steady motion and oscillation by different parts of themselves.
TEST(ModeResidual, OfAFilterWhoseCornerIsOffByItsUncertaintyLiesWithinItsOwn) {
  int out = 0;  // far outside where that uncertainty is not stated
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    std::mt19937_64 random(seed);
    const Chain chain = any_chain(random);
    Rig rig = rig_of(chain, kHz);
    rig.channels[1].lowpass = {FilterKind::rc, 4, 6 * kHz, 1.5e-3 * kHz};
    Rig read = rig;
    read.channels[1].lowpass.hz += rig.channels[1].lowpass.hz_u;
    const SeenMode mode = mode_of(read, chain);
    const ElementsResult identified = identified_by(rig, read, chain);
    const ModeResidual residual(rig, identified, 2 * M_PI * kHz, mode);
    // One source, one standard deviation of it, beside a little noise.
    EXPECT_LT(residual.chi2(), 1.2) << seed;
    rig.channels[1].lowpass.hz_u = 0.0;
    const ElementsResult unstated = identified_by(rig, read, chain);
    out += ModeResidual(rig, unstated, 2 * M_PI * kHz, mode).chi2() > 30;
  }
  EXPECT_GT(out, 30);
}

// A pole one decay rate off, known to 0.18 of it: the parabola says 5.6 standard deviations, the likelihood 5.0.
TEST(ModeResidual, APoleFarFromTheChainsOwnIsWeighedByTheLikelihood) {
  const Chain chain{Boundary::free, {2.0}, {8e3}, {4.0}};
  const Rig rig = rig_of(chain, kHz);
  SeenMode mode = mode_of(rig, chain);
  const double decays = -mode.pole.real();
  mode.pole += Complex{0.0, decays};
  mode.covariance.bottomRightCorner<2, 2>() = std::pow(0.18 * decays, 2) * Eigen::Matrix2d::Identity();
  const ElementsResult identified = identified_by(rig, rig, chain);
  const auto doubts = [&](double seen_s) {
    mode.seen_s = seen_s;
    Dwell dwell;
    check_modes(rig, identified, 2 * M_PI * kHz, {&mode, 1}, dwell);
    return dwell.doubts.size();
  };
  EXPECT_EQ(doubts(0.0), 1u) << "without the time seen the parabola counts";
  EXPECT_EQ(doubts(5.0 / decays), 0u);
  // The figures told to people are those near the pole.
  const ModeResidual near(rig, identified, 2 * M_PI * kHz, mode), widened(rig, identified, 2 * M_PI * kHz, mode, 1.25);
  EXPECT_NEAR(widened.chi2(), near.chi2() / 1.25, 0.01 * near.chi2());
  EXPECT_TRUE(widened.change_covariance(0).isApprox(near.change_covariance(0)));
}

// A bracket that rings at the mode's own pole falsifies one amplitude; the pole is as it was.
TEST(ModeResidual, ItsTestOfThePoleAloneDoesNotHeedAnAmplitudeAndHeedsAMass) {
  const double omega = 2 * M_PI * kHz;
  for (const Chain& chain : {Chain{Boundary::free, {8, 5}, {9000, 6000}, {40, 25}},
                             Chain{Boundary::clamped, {8, 5}, {9000, 6000, 7000}, {40, 25, 30}}}) {
    const Rig rig = rig_of(chain, kHz);
    const Eigen::VectorXcd shape = natural_modes(chain).front().shape;
    SeenMode mode = mode_of(rig, chain);
    mode.amplitude(1) *= 1.001;
    const ModeResidual rings(rig, identified_by(rig, rig, chain), omega, mode);
    EXPECT_LT(rings.by_chance(), 1e-6);
    EXPECT_GT(rings.pole_by_chance(shape), 0.1);

    Rig stated = rig;
    stated.masses[1] *= 1.01;
    const ElementsResult of_mass = identified_by(stated, rig, chain);
    const SeenMode sound = mode_of(rig, chain);
    EXPECT_LT(ModeResidual(stated, of_mass, omega, sound).pole_by_chance(shape), 1e-6);
    // All masses of a free chain together move no pole: what no data can tell.
    if (chain.boundary == Boundary::clamped) continue;
    stated = rig;
    for (double& mass : stated.masses) mass *= 1.5;
    const ElementsResult of_all = identified_by(stated, rig, chain);
    EXPECT_GT(ModeResidual(stated, of_all, omega, sound).pole_by_chance(shape), 0.1);
  }
}

}  // namespace
}  // namespace dwell
