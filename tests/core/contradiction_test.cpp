#include "core/chain/contradiction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/chain/identify.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kContradictionOmega = 2 * M_PI * 4;

// clamped_chain() with a second transducer on mass 2 and one across element 2.
Rig contradicted_rig() {
  Rig rig = rig_of(clamped_chain(), 4);
  Channel second = rig.channels[2];
  second.name = "y2b";
  rig.channels.push_back(second);
  Channel across = rig.channels[2];
  across.name = "d2";
  across.relative_to = 1;
  rig.channels.push_back(across);
  return rig;
}

std::vector<Evidence> evidence_of(const Rig& rig) {
  const SteadyResponse steady = steady_response(clamped_chain(), kContradictionOmega, 0.002);
  std::vector<Evidence> out(rig.channels.size());
  for (std::size_t c = 0; c < out.size(); ++c) {
    const Channel& channel = rig.channels[c];
    Complex y = channel.measures == Quantity::force ? steady.F : steady.Y[static_cast<std::size_t>(channel.at)];
    if (channel.relative_to) y -= steady.Y[static_cast<std::size_t>(*channel.relative_to)];
    out[c].usable = true;
    out[c].X[0] = y;
    out[c].dof = 2000;
    out[c].covariance = Eigen::Matrix2d::Identity() * std::norm(1e-4 * y);
  }
  return out;
}

std::vector<Doubt> doubts_of(const Rig& rig, const std::vector<Evidence>& evidence) {
  const Eigen::MatrixXd G = observation_matrix(rig);
  return contradictions(rig, G, solve_observation(G, observation_weights(rig, evidence, kContradictionOmega)), evidence,
                        kContradictionOmega);
}

TEST(Contradiction, ASecondTransducerOffByMoreThanIsStatedRaisesADoubtThatNamesItAndItsElements) {
  const Rig rig = contradicted_rig();
  std::vector<Evidence> evidence = evidence_of(rig);
  EXPECT_TRUE(doubts_of(rig, evidence).empty());
  evidence[4].X[0] *= 1.01;
  const std::vector<Doubt> doubts = doubts_of(rig, evidence);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_EQ(doubts[0].elements, (std::vector<int>{1, 2, 3}));
  for (const char* named : {"y2", "y2b", " %; allowed are", "elements 1, 2 and 3", "scale_u"})
    EXPECT_NE(doubts[0].what.find(named), std::string::npos) << doubts[0].what;
}

TEST(Contradiction, WhatAllShareIsNone) {
  Rig rig = contradicted_rig();
  rig.devices = {{"one", 0.0, 1e-5}};
  for (Channel& channel : rig.channels) channel.device = 0;
  std::vector<Evidence> evidence = evidence_of(rig);
  for (Evidence& one : evidence)
    one.X[0] *= std::polar(1.0, -kContradictionOmega * 0.01);  // a thousand times what is stated
  EXPECT_TRUE(doubts_of(rig, evidence).empty());
  evidence[4].X[0] *= std::polar(1.0, -kContradictionOmega * 1e-4);  // one of them late by more than its noise
  EXPECT_EQ(doubts_of(rig, evidence).size(), 1u);
}

TEST(Contradiction, HealthyTransducersRaiseNoneInThousandsOfDwells) {
  Rig rig = contradicted_rig();
  for (Channel& channel : rig.channels) channel.scale_u = 2e-3, channel.delay_u_s = 2e-5;
  const std::vector<Evidence> exact = evidence_of(rig);
  std::mt19937_64 rng(7);
  std::normal_distribution<double> normal;
  int doubted = 0;
  for (int dwell = 0; dwell < 5000; ++dwell) {
    std::vector<Evidence> seen = exact;
    for (std::size_t c = 0; c < seen.size(); ++c) {
      const double sigma = std::sqrt(exact[c].covariance(0, 0));
      seen[c].X[0] =
          seen[c].X[0] * (1 + 2e-3 * normal(rng)) * std::polar(1.0, -kContradictionOmega * 2e-5 * normal(rng)) +
          Complex{sigma * normal(rng), sigma * normal(rng)};
    }
    doubted += doubts_of(rig, seen).empty() ? 0 : 1;
  }
  EXPECT_EQ(doubted, 0);
}

}  // namespace
}  // namespace dwell
