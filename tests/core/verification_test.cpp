#include "core/verify/verification.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/base/instants.hpp"
#include "core/verify/verification_readings.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kFrequency_hz = 4.0;

// A rig is played from rest, identified, and verified on the transient before its data count.
struct Verified {
  Dwell dwell;
  Verification verification;
};

Verified verified(const Chain& truth, const Rig& stated, DrivenChain::Start start = DrivenChain::Start::rest,
                  double accuracy = 0.05, double noise = 2e-3, std::uint64_t seed = 1,
                  const std::function<void(Record&, double)>& alter = {}) {
  const Rig true_rig = rig_of(truth, kFrequency_hz);
  const Drive drive{.frequency_hz = kFrequency_hz, .amplitude = 5e-3, .ramp_s = 0.1};
  Sampling sampling{.rate_hz = 400, .skew_s = 0.0005, .sigma = {}};
  for (const Channel& channel : true_rig.channels)
    sampling.sigma.push_back(noise * (channel.measures == Quantity::force ? 50.0 : 5e-3));
  Bench bench(truth, true_rig, drive, start, sampling, seed);
  bench.pipeline = Pipeline(stated);
  VerificationReadings readings(stated.channels.size());
  bench.alter = [&](Record& record, double t_s) {
    readings.take(bench.pipeline.readings());
    if (alter) alter(record, t_s);
  };
  bench.run(30);
  bench.finish();
  readings.take(bench.pipeline.readings());
  Verified out;
  if (bench.dwells.empty()) return out;
  out.dwell = bench.dwells.front();
  out.verification = verify_transient(stated, out.dwell, readings.since(0), accuracy);
  return out;
}

std::string told(const Verification& v) {
  std::string text = to_string(v.verdict);
  for (const std::string& reason : v.reasons) text += "; " + reason;
  for (const ChannelComparison& c : v.channels)
    text += "\n channel " + std::to_string(c.channel) + ": error " + std::to_string(c.error) + " U " +
            std::to_string(c.U) + " noise " + std::to_string(c.noise) + " beyond " + std::to_string(c.beyond_steady) +
            " e_n " + std::to_string(c.e_n);
  text += "\n chi2 " + std::to_string(v.chi2) + " p " + std::to_string(v.p);
  for (const std::string& evidence : v.evidence) text += "\n " + evidence;
  return text;
}

TEST(Verification, CallsARightModelAdequateAndConsistent) {
  for (const Chain& chain : {clamped_chain(), free_chain()}) {
    const Verified seen = verified(chain, rig_of(chain, kFrequency_hz));
    EXPECT_EQ(seen.verification.verdict, Verdict::adequate) << told(seen.verification);
    EXPECT_TRUE(seen.verification.consistent.value_or(false)) << told(seen.verification);
    EXPECT_LT(seen.verification.e_n, 1.0);
  }
}

TEST(Verification, CallsAWrongMassNotAdequate) {
  Rig stated = rig_of(clamped_chain(), kFrequency_hz);
  stated.masses[1] *= 1.5;
  const Verified seen = verified(clamped_chain(), stated);
  EXPECT_EQ(seen.verification.verdict, Verdict::not_adequate) << told(seen.verification);
  EXPECT_FALSE(seen.verification.consistent.value_or(true)) << told(seen.verification);
}

// The first mass of the free chain has little part in how it moves: the prediction is right to 0.4 %, and yet off.
TEST(Verification, FindsInconsistentWhatHardlyMovesThePrediction) {
  Rig stated = rig_of(free_chain(), kFrequency_hz);
  stated.masses[0] *= 1.5;
  const Verified seen = verified(free_chain(), stated);
  EXPECT_NE(seen.verification.verdict, Verdict::adequate) << told(seen.verification);
  EXPECT_FALSE(seen.verification.consistent.value_or(true)) << told(seen.verification);
}

TEST(Verification, CallsNothingAdequateThatWasNotPutToTheTest) {
  const Verified seen = verified(clamped_chain(), rig_of(clamped_chain(), kFrequency_hz), DrivenChain::Start::steady);
  EXPECT_EQ(seen.verification.verdict, Verdict::not_verified) << told(seen.verification);
}

}  // namespace
}  // namespace dwell
