#include "core/rig/usable_observation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/complex.hpp"
#include "core/model/forward.hpp"
#include "core/rig/observation.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

// A rig with a second transducer on mass 2.
Rig rig_with_redundant_channels() {
  Rig rig = rig_of(clamped_chain(), 4.0);
  rig.channels.push_back(rig.channels[2]);
  rig.channels.back().name = "y2b";
  return rig;
}

TEST(UsableObservation, GivesTheStateThatTheDecompositionGivesWhicheverRedundantTransducerIsLeft) {
  const Rig rig = rig_with_redundant_channels();
  const Eigen::MatrixXd G = observation_matrix(rig);
  Eigen::VectorXcd x(G.cols());
  x << Complex{1.0, 0.2}, Complex{0.3, -0.4}, Complex{-0.5, 0.1}, Complex{20, 3};
  for (const int dead : {-1, 2, 4}) {
    UsableObservation observation(rig, G);
    for (int c = 0; c < G.rows(); ++c)
      if (c == dead)
        observation.leave_out(c);
      else
        observation.observe(c, (G.row(c) * x).value());
    Eigen::VectorXcd found(G.cols());
    ASSERT_TRUE(observation.solve(found)) << "dead: " << dead;
    EXPECT_LT((found - x).norm(), 1e-9 * x.norm());
  }
}

TEST(UsableObservation, SaysSoWhereTheTransducersThatAreLeftDoNotDetermineTheChain) {
  const Rig rig = rig_with_redundant_channels();
  const Eigen::MatrixXd G = observation_matrix(rig);
  UsableObservation observation(rig, G);
  for (int c = 0; c < G.rows(); ++c)
    if (c != 1) observation.observe(c, 1.0);
  Eigen::VectorXcd found(G.cols());
  EXPECT_FALSE(observation.solve(found));
}

// With one of two transducers on a mass dead from the beginning, the verdict comes as soon as with both.
TEST(Pipeline, ADeadRedundantTransducerDoesNotDelayTheVerdict) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_with_redundant_channels();
  Drive drive;
  drive.frequency_hz = 4.0;
  drive.amplitude = 0.002;
  double verdict_s[2];
  for (const bool dead : {false, true}) {
    const auto steady = steady_response(chain, 2 * M_PI * 4.0, 0.002);
    Sampling sampling{.rate_hz = 200, .sigma = {}};
    for (const auto& Y : steady.Y) sampling.sigma.push_back(2e-3 * std::abs(Y));
    sampling.sigma.push_back(2e-3 * std::abs(steady.F));
    sampling.sigma.push_back(sampling.sigma[2]);
    Bench bench(chain, rig, drive, DrivenChain::Start::rest, sampling, 1);
    bench.alter = [&](Record& record, double) {
      if (dead && record.channel == 4) record.value = NAN;
    };
    bench.run(60, [&] { return bench.pipeline.state() == State::measuring; });
    verdict_s[dead] = bench.now_s();
    bench.run(bench.now_s() + 10);
    for (const Warning& warning : bench.pipeline.current().warnings)
      EXPECT_NE(warning.kind, WarningKind::growing_chain) << warning.what;
  }
  EXPECT_LT(verdict_s[1], 1.2 * verdict_s[0]) << verdict_s[0];
}

}  // namespace
}  // namespace dwell
