// The chain as it can be identified while the rig settles.
#include "core/chain/provisional_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/complex.hpp"
#include "core/model/forward.hpp"
#include "core/rig/observation.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kFourHz = kTwoPi * 4.0;

// Shows `provisional` the steady motion of a chain.
void show_steady(const Chain& chain, ProvisionalChain& provisional) {
  const SteadyResponse steady = steady_response(chain, kFourHz, 0.002);
  for (int k = 0; k <= chain.mass_count(); ++k) provisional.observe(k, steady.Y[static_cast<std::size_t>(k)], kFourHz);
  if (chain.boundary == Boundary::clamped) provisional.observe(chain.mass_count() + 1, steady.F, kFourHz);
}

TEST(ProvisionalChain, KnowsTheNaturalOscillationsOfTheChainWhoseSteadyMotionItIsShown) {
  for (const Chain& chain : {clamped_chain(), free_chain()}) {
    const Rig rig = rig_of(chain, 4.0);
    ProvisionalChain provisional(rig, observation_matrix(rig));
    EXPECT_TRUE(provisional.last().empty());
    EXPECT_TRUE(std::isnan(provisional.time_constant_s()));
    show_steady(chain, provisional);
    ASSERT_TRUE(provisional.solve(kFourHz));
    EXPECT_NEAR(provisional.time_constant_s(), 1 / slowest_decay_rate(chain), 1e-9 / slowest_decay_rate(chain));
    ASSERT_EQ(provisional.last().size(), 2u);
    for (const Complex& pole : natural_values(chain)) {
      if (pole.imag() < 0) continue;
      const auto nearest = [&](Complex a, Complex b) { return std::abs(a - pole) < std::abs(b - pole); };
      EXPECT_LT(std::abs(*std::min_element(provisional.last().begin(), provisional.last().end(), nearest) - pole),
                1e-8 * std::abs(pole));
    }
  }
}

TEST(ProvisionalChain, KeepsWhatItKnewWhereTheChannelsThatDeliverDoNotDetermineTheChain) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4.0);
  ProvisionalChain provisional(rig, observation_matrix(rig));
  show_steady(chain, provisional);
  ASSERT_TRUE(provisional.solve(kFourHz));
  const double known_s = provisional.time_constant_s();
  provisional.leave_out(1);
  EXPECT_FALSE(provisional.solve(kFourHz));
  EXPECT_EQ(provisional.time_constant_s(), known_s);
  EXPECT_EQ(provisional.last().size(), 2u);
  provisional.forget_time_constant();
  EXPECT_TRUE(std::isnan(provisional.time_constant_s()));
}

// Of a chain that looks active the time constant is that of the chain as it looks, the poles are of one that decays.
TEST(ProvisionalChain, GivesPolesThatDecayWhereTheChainLooksActive) {
  Chain chain = clamped_chain();
  for (double& damping : chain.damping) damping = -damping;
  const Rig rig = rig_of(chain, 4.0);
  ProvisionalChain provisional(rig, observation_matrix(rig));
  show_steady(chain, provisional);
  ASSERT_TRUE(provisional.solve(kFourHz));
  EXPECT_TRUE(std::isinf(provisional.time_constant_s()));
  for (const Complex& pole : provisional.last()) EXPECT_LT(pole.real(), 0.0);
}

}  // namespace
}  // namespace dwell
