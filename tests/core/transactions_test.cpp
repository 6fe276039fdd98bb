#include "core/stream/transactions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/chain/estimate.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

Rig rig_on_one_device() {
  Rig rig = rig_of(clamped_chain(), 4);
  rig.devices = {{"line"}, {"other"}};
  for (Channel& channel : rig.channels) channel.device = 0;
  return rig;
}

Record sample_of(int channel, std::int64_t t_ns, std::uint32_t half_ns = 1000) {
  Record record;
  record.t_ns = t_ns;
  record.t_half_ns = half_ns;
  record.channel = static_cast<std::uint16_t>(channel);
  return record;
}

TEST(Transactions, ChannelsThatCarryOneStampAreReadTogether) {
  Transactions transactions(rig_on_one_device());
  for (int poll = 0; poll < 3; ++poll) {
    for (const int channel : {0, 1, 2}) transactions.sample(sample_of(channel, 1000 * poll));
    transactions.sample(sample_of(3, 1000 * poll + 500));
  }
  EXPECT_EQ(transactions.of(0), 0);
  EXPECT_EQ(transactions.of(1), 0);
  EXPECT_EQ(transactions.of(2), 0);
  EXPECT_EQ(transactions.of(3), 3);
}

TEST(Transactions, AReadingThatIsMissingNowAndThenDoesNotPartThem) {
  Transactions transactions(rig_on_one_device());
  for (int poll = 0; poll < 3; ++poll)
    for (const int channel : {0, 1, 2}) transactions.sample(sample_of(channel, 1000 * poll));
  for (const int channel : {1, 2}) transactions.sample(sample_of(channel, 3000));
  EXPECT_EQ(transactions.of(2), 0);
}

// 8000 polls of two stations whose instants jitter by a millisecond meet to the nanosecond once in a hundred runs.
TEST(Transactions, StampsThatMeetByChanceDoNotUniteTwoStations) {
  Transactions transactions(rig_on_one_device());
  for (int poll = 0; poll < 100; ++poll)
    for (const int channel : {0, 1, 2, 3})
      transactions.sample(sample_of(channel, 1000 * poll + (channel == 3 && poll % 10 != 0 ? 500 : 0)));
  EXPECT_EQ(transactions.of(2), 0);
  EXPECT_EQ(transactions.of(3), 3);
}

TEST(Transactions, DevicesStampsOfOtherWidthAndReplacedStampsAreApart) {
  Rig rig = rig_on_one_device();
  rig.channels[1].device = 1;
  Transactions transactions(rig);
  transactions.sample(sample_of(0, 0));
  transactions.sample(sample_of(1, 0));
  transactions.sample(sample_of(2, 10, 1000));
  transactions.sample(sample_of(3, 10, 2000));
  Record replaced = sample_of(0, 20);
  replaced.flags = kStampReplaced;
  transactions.sample(replaced);
  replaced.channel = 2;
  transactions.sample(replaced);
  for (int channel = 0; channel < 4; ++channel) EXPECT_EQ(transactions.of(channel), channel);
}

// Z_3 = F / Y_2: an error δτ of either instant moves r_3 by c_3 δτ. In one transaction it cancels, in two it does not.
TEST(Transactions, TheTurnaroundCancelsWithinOneTransactionAlone) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_on_one_device();
  const double omega = 2 * M_PI * 4, u_s = 1e-3;
  const SteadyResponse steady = steady_response(chain, omega, 0.002);
  std::vector<Evidence> evidence(4);
  for (std::size_t c = 0; c < 4; ++c) {
    evidence[c].usable = true;
    evidence[c].X[0] = c < 3 ? steady.Y[c] : steady.F;
    evidence[c].dof = 1000;
    evidence[c].covariance = Eigen::Matrix2d::Identity() * std::norm(1e-7 * evidence[c].X[0]);
    evidence[c].turnaround_u_s = u_s;
    evidence[c].transaction = c < 3 ? 0 : 3;
  }
  const Gain gain = solve_observation(observation_matrix(rig), observation_weights(rig, evidence, omega));
  const ElementsResult two = estimate_elements(rig, gain, evidence, {omega, 0, 0});
  EXPECT_NEAR(two.elements[2].damping.u, std::sqrt(2.0) * chain.stiffness[2] * u_s, 0.01 * chain.stiffness[2] * u_s);
  evidence[3].transaction = 0;
  const ElementsResult one = estimate_elements(rig, gain, evidence, {omega, 0, 0});
  EXPECT_LT(one.elements[2].damping.u, 0.01 * chain.stiffness[2] * u_s);
}

// Two stations behind one device: the load cell's amplifier samples 1 ms before the middle of its turnaround.
TEST(Transactions, TwoStationsBehindOneDeviceKeepTheirInstantsApartInTheBudget) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_on_one_device();
  const double early_s = 1e-3;
  Bench bench(chain, rig, steady_drive(4), DrivenChain::Start::steady,
              {.rate_hz = 200, .skew_s = 0, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  bench.alter = [&](Record& record, double) {
    record.t_half_ns = 1'000'000;
    if (record.channel == 3) record.t_ns += std::llround(early_s * 1e9);
  };
  bench.run(20);
  const Dwell dwell = bench.pipeline.current();
  ASSERT_EQ(dwell.state, State::measuring);
  ASSERT_TRUE(dwell.elements[2].identifiable);
  const Coefficient& r = dwell.elements[2].damping;
  EXPECT_GT(std::abs(r.value - chain.damping[2]), 0.2 * chain.damping[2]);  // far off, and said to be
  EXPECT_LT(std::abs(r.value - chain.damping[2]), 3 * r.u);
  const std::vector<BudgetShare>& budget = dwell.elements[2].budget;
  const auto share = std::find_if(budget.begin(), budget.end(),
                                  [](const BudgetShare& one) { return one.source == "turnaround of line (reaction)"; });
  ASSERT_NE(share, budget.end());
  EXPECT_NEAR(share->damping_share, 0.5, 0.05);
}

// The table of phases showed ± 0.45° where the coefficients, which rest on the same phases, implied ± 0.006°.
TEST(Transactions, TheRelativePhaseIsFreeOfWhatBothChannelsShare) {
  Rig rig = rig_on_one_device();
  rig.devices[0].delay_u_s = 1e-3;
  Bench bench(clamped_chain(), rig, steady_drive(4), DrivenChain::Start::steady,
              {.rate_hz = 200, .skew_s = 0, .sigma = {1e-6, 1e-6, 1e-6, 0.01}});
  bench.alter = [&](Record& record, double) {
    record.t_half_ns = 1'000'000;
    if (record.channel == 3) record.t_ns += 1'000'000;  // a transaction of its own
  };
  bench.run(20);
  const Dwell dwell = bench.pipeline.current();
  ASSERT_EQ(dwell.state, State::measuring);
  const double omega = 2 * M_PI * 4, turnaround_u_s = 1e-3 / std::sqrt(3.0);
  EXPECT_EQ(dwell.phasors[0].u_relative_phase_rad, 0.0);
  EXPECT_GT(dwell.phasors[1].u_phase_rad, omega * std::hypot(turnaround_u_s, 0.9e-3));
  EXPECT_LT(dwell.phasors[1].u_relative_phase_rad, 0.01 * dwell.phasors[1].u_phase_rad);
  EXPECT_NEAR(dwell.phasors[3].u_relative_phase_rad / (omega * turnaround_u_s * std::sqrt(2.0)), 1.0, 0.05);
}

}  // namespace
}  // namespace dwell
