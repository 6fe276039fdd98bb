// A dwell over CANopen without a kernel, a thread or a clock: the chain's motion through simulated nodes, SYNC and the
// master, and back to the chain's coefficients, while answers are lost and late and one node restarts.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "core/chain/identify.hpp"
#include "core/model/driven_chain.hpp"
#include "tests/drivers/canopen_bench.hpp"

namespace dwell::canopen {
namespace {

using rigsim::Transducer;
using test::CanopenBench;

const Chain kChain{Boundary::clamped, {12, 8, 5}, {24000, 8000, 6000, 8000}, {60, 45, 30, 40}};
constexpr double kFrequency_hz = 4.0, kOmega = 2.0 * std::numbers::pi * kFrequency_hz;

double seconds_of(std::int64_t raw_ns) {
  return 1e-9 * static_cast<double>(raw_ns - test::kRawOffset_ns - 1'000 * kSecond_ns);
}

// Least squares of offset and harmonic, each sample at its own instant: Im(Y exp(jωt)).
Complex phasor(const std::vector<dwell_sample>& samples, double scale) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const dwell_sample& sample : samples) {
    const double angle = kOmega * seconds_of(sample.t_ns);
    const Eigen::Vector3d row(1.0, std::sin(angle), std::cos(angle));
    normal += row * row.transpose();
    right += row * scale * sample.raw;
  }
  const Eigen::Vector3d fitted = normal.ldlt().solve(right);
  return {fitted[1], fitted[2]};
}

TEST(CanopenDwell, GivesTheChainsCoefficientsThoughAnswersAreLostAndLateAndANodeRestarts) {
  CanopenBench bench({{1, Transducer::encoder},
                      {2, Transducer::input},
                      {3, Transducer::encoder},
                      {4, Transducer::input},
                      {5, Transducer::load_cell}});
  DrivenChain chain(kChain, {kFrequency_hz, 0.005, 0.0, 0.0, {}}, DrivenChain::Start::steady);
  bench.quantity = [&](std::uint8_t node, std::int64_t raw_ns) {
    const ChainMotion& motion = chain.at(seconds_of(raw_ns));
    return node == 5 ? motion.ground_force : motion.y[node - 1U];
  };
  std::uint32_t random = 1;
  bench.fate = [&](const can_frame& frame) -> std::optional<std::int64_t> {
    random = random * 1664525U + 1013904223U;
    if (frame.can_id < kFirstPdo || frame.can_id > kLastPdo) return 0;
    if ((random >> 24U) < 2) return std::nullopt;
    return (random >> 24U) < 4 ? (random >> 8U) % 40 * kMs_ns : (random >> 8U) % 2 * kMs_ns;
  };
  bench.start();
  bench.run_for(15 * kSecond_ns);
  bench.node(3).reset(bench.now_ns());
  bench.run_for(15 * kSecond_ns);

  EXPECT_GT(bench.host.counted(DWELL_FAULT_LATE_ANSWER), 10);
  EXPECT_GT(bench.host.counted(DWELL_FAULT_TIMEOUT), 10);
  std::vector<Complex> Y;
  for (std::uint16_t channel = 10; channel < 14; ++channel) {
    const auto samples = bench.host.samples(channel);
    ASSERT_GT(samples.size(), 2000U);
    Y.push_back(phasor(samples, 1e-9));
  }
  const Complex F = phasor(bench.host.samples(14), 1.0);
  const std::vector<Complex> d{Y[1] - Y[0], Y[2] - Y[1], Y[3] - Y[2]};
  std::vector<Complex> Z(4);
  identify(kChain.boundary, kChain.masses, kOmega, Y, d, F, Z);
  for (std::size_t k = 0; k < Z.size(); ++k) {
    // One count is 1 nm; the load cell's float has 24 bits.
    EXPECT_NEAR(stiffness(Z[k]) / kChain.stiffness[k], 1.0, 1e-5) << k;
    EXPECT_NEAR(damping(Z[k], kOmega) / kChain.damping[k], 1.0, 1e-4) << k;
  }
}

}  // namespace
}  // namespace dwell::canopen
