#include "core/verify/verification.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "core/base/instants.hpp"
#include "core/verify/verification_readings.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/under_sanitizer.hpp"

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
  out.verification = verify_model(stated, out.dwell, readings.since(0), accuracy);
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

TEST(Verification, NamesTheGapThatLeavesTooLittleMotionBeforeTheDataThatCount) {
  const Rig rig = rig_of(clamped_chain(), kFrequency_hz);
  const Dwell dwell = verified(clamped_chain(), rig).dwell;
  std::vector<ChannelReadings> before(rig.channels.size());
  const auto reads = [&](double from_s, double until_s) {
    for (ChannelReadings& of : before)
      for (double t_s = from_s; t_s < until_s; t_s += 0.0025) {
        of.t_ns.push_back(to_ns(t_s));
        of.value.push_back(std::sin(25 * t_s));
      }
  };
  reads(0.0, dwell.settled_s - 0.5);
  EXPECT_EQ(transient_before(rig, dwell, clamped_chain(), before).fault, "");
  reads(dwell.settled_s - 0.01, dwell.settled_s + 0.1);
  const std::string fault = transient_before(rig, dwell, clamped_chain(), before).fault;
  EXPECT_NE(fault.find("between a gap in the readings of y0, which ends at "), std::string::npos) << fault;
}

TEST(Verification, CallsAWrongMassNotAdequate) {
  Rig stated = rig_of(clamped_chain(), kFrequency_hz);
  stated.masses[1] *= 1.5;
  const Verified seen = verified(clamped_chain(), stated);
  EXPECT_EQ(seen.verification.verdict, Verdict::not_adequate) << told(seen.verification);
  EXPECT_FALSE(seen.verification.consistent.value_or(true)) << told(seen.verification);
}

// A polled reading whose instant is known to ±0.2 ms: such noise goes with velocity, and the transient has another.
TEST(Verification, FindsARightModelConsistentWhereInstantsScatter) {
  const auto scattered = [](const Rig& stated, std::uint64_t seed) {
    std::mt19937_64 rng(seed);
    std::uniform_real_distribution<double> off_s(-2e-4, 2e-4);
    return verified(clamped_chain(), stated, DrivenChain::Start::rest, 0.05, 2e-4, seed,
                    [&](Record& record, double) { record.t_ns += to_ns(off_s(rng)); })
        .verification;
  };
  const Rig right = rig_of(clamped_chain(), kFrequency_hz);
  Rig wrong = right;
  wrong.masses[1] *= 1.1;
  const int times = kUnderSanitizer ? 3 : 10;
  int inconsistent = 0;
  std::string which;
  for (int seed = 1; seed <= times; ++seed) {
    const Verification seen = scattered(right, static_cast<std::uint64_t>(seed));
    if (seen.consistent.value_or(false)) continue;
    ++inconsistent;
    which += told(seen) + "\n";
  }
  EXPECT_LE(inconsistent, 1) << which;  // one false alarm in a hundred
  EXPECT_FALSE(scattered(wrong, 1).consistent.value_or(true));
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

// Two dwells of one recording; the coefficients are those of the one asked for.
Verified verified_on_both(const Chain& truth, Rig stated, int of, DrivenChain::Start start, double second_hz = 5.0) {
  Rig true_rig = rig_of(truth, kFrequency_hz);
  for (Rig* rig : {&true_rig, &stated}) {
    rig->excitation.search_low_hz = 3.0;
    rig->excitation.search_high_hz = 8.0;
  }
  Sampling sampling{.rate_hz = 200, .skew_s = 0.0005, .sigma = {}};
  for (const Channel& channel : true_rig.channels)
    sampling.sigma.push_back(2e-3 * (channel.measures == Quantity::force ? 50.0 : 5e-3));
  Bench bench(truth, true_rig, {.frequency_hz = kFrequency_hz, .amplitude = 5e-3, .ramp_s = 0.1}, start, sampling, 1);
  bench.pipeline = Pipeline(stated);
  VerificationReadings readings(stated.channels.size());
  bench.alter = [&](Record&, double) { readings.take(bench.pipeline.readings()); };
  bench.run(20);
  bench.set_drive({.frequency_hz = second_hz, .amplitude = 4e-3, .ramp_s = 0.1});
  bench.run(40);
  bench.finish();
  readings.take(bench.pipeline.readings());
  // The change of the drive is a dwell of its own, which does not settle.
  std::erase_if(bench.dwells, [](const Dwell& dwell) { return !std::isfinite(dwell.settled_s); });
  EXPECT_EQ(bench.dwells.size(), 2u);
  if (bench.dwells.size() != 2) return {};
  const Dwell &first = bench.dwells[0], &second = bench.dwells[1];
  const OtherDwell one{first, readings.between(0, to_ns(first.end_s))};
  const OtherDwell two{second, readings.between(to_ns(first.end_s), to_ns(second.end_s))};
  const OtherDwell &own = of == 1 ? one : two, &other = of == 1 ? two : one;
  return {own.dwell, verify_model(stated, own.dwell, own.readings, 0.05, {other})};
}

TEST(Verification, HoldsTheCoefficientsOfOneDwellAgainstAnother) {
  for (const int of : {1, 2}) {
    const Verification seen =
        verified_on_both(clamped_chain(), rig_of(clamped_chain(), kFrequency_hz), of, DrivenChain::Start::rest)
            .verification;
    EXPECT_EQ(seen.verdict, Verdict::adequate) << told(seen);
    EXPECT_TRUE(seen.consistent.value_or(false)) << told(seen);
    ASSERT_EQ(seen.evidence.size(), 2u);
    EXPECT_EQ(seen.evidence[0].rfind("transient from ", 0), 0u) << seen.evidence[0];
    EXPECT_NE(seen.evidence[1].find(of == 1 ? " at 5 Hz from " : " at 4 Hz from "), std::string::npos)
        << seen.evidence[1];
    for (const ChannelComparison& channel : seen.channels) EXPECT_GT(channel.frac, 0.9999) << told(seen);
  }
}

// Begun in the steady motion, the first dwell has no transient to speak of: another frequency tells of a wrong mass.
TEST(Verification, FindsAWrongMassByAnotherFrequency) {
  Rig stated = rig_of(clamped_chain(), kFrequency_hz);
  stated.masses[1] *= 1.5;
  const Verification seen = verified_on_both(clamped_chain(), stated, 1, DrivenChain::Start::steady).verification;
  EXPECT_EQ(seen.verdict, Verdict::not_adequate) << told(seen);
  ASSERT_FALSE(seen.evidence.empty());
  EXPECT_NE(seen.evidence.back().find(" at 5 Hz from "), std::string::npos) << seen.evidence.back();
  double least = 1.0;
  for (const ChannelComparison& channel : seen.channels) least = std::min(least, channel.frac);
  EXPECT_LT(least, 0.999) << told(seen);
}

}  // namespace
}  // namespace dwell
