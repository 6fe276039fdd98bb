#include "core/verify/verification_causes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "core/base/instants.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/verify/verification.hpp"
#include "core/verify/verification_readings.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/faulty_motion.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell {
namespace {

constexpr double kShaken_m = 0.005, kShaken_hz = 4.0, kPolled_hz = 200.0;

// A rig that has what its file does not, from rest through the pipeline; then verified, and its causes looked for where
// the verification asks for them.
struct Explained {
  Verification verification;
  bool asked = false;
};

Explained explained(const Chain& chain, const Rig& stated, const Faults& faults, std::uint64_t seed,
                    int late_channel = -1) {
  constexpr std::int64_t late_ns = 1'000'000;
  FaultyMotion motion(chain, faults, kShaken_m, {{kShaken_hz, 1.0}});
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  Pipeline pipeline(stated);
  VerificationReadings readings(stated.channels.size());
  for (int i = 0; i < 12 * static_cast<int>(kPolled_hz); ++i) {
    const auto state = motion.at(i / kPolled_hz);
    for (int pass = 0; pass < 2; ++pass)
      for (int c = 0; c < static_cast<int>(stated.channels.size()); ++c) {
        if ((c == late_channel) != (pass == 1)) continue;
        const Channel& channel = stated.channels[static_cast<std::size_t>(c)];
        const bool force = channel.measures == Quantity::force;
        Record record;
        record.t_ns = to_ns(i / kPolled_hz) + (pass == 1 ? late_ns : 0);
        record.channel = static_cast<std::uint16_t>(c);
        record.value = (force ? state.force : state.y[static_cast<std::size_t>(channel.at)]) +
                       2e-3 * kShaken_m * (force ? chain.stiffness.back() : 1.0) * normal(rng);
        (void)pipeline.push(record);
        readings.take(pipeline.readings());
      }
  }
  const bool completed = (pipeline.finish() & kCompleted) != 0;
  EXPECT_TRUE(completed);
  if (!completed) return {};
  const Dwell& dwell = pipeline.completed();
  Explained out{verify_model(stated, dwell, readings.since(0), 0.05), false};
  out.asked = asks_for_causes(out.verification, dwell);
  if (out.asked) tell_causes(find_causes(stated, readings.since(0), to_ns(dwell.verdict_s)), out.verification);
  return out;
}

bool names(const Explained& explained, const std::string& what) {
  return std::any_of(explained.verification.missing.begin(), explained.verification.missing.end(),
                     [&](const MissingTerm& term) { return term.what == what; });
}

std::string told(const Explained& explained) {
  const Verification& v = explained.verification;
  std::string text = to_string(v.verdict);
  for (const std::string& reason : v.reasons) text += "\n" + reason;
  for (const MissingTerm& term : v.missing)
    text += "\n" + term.what + " " + std::to_string(term.value) + " ± " + std::to_string(term.u) + ", gain " +
            std::to_string(term.gain);
  for (const std::string& one : v.cannot_be_checked) text += "\nunchecked: " + one;
  return text;
}

TEST(VerificationCauses, NameADamperToGround) {
  const Chain chain = free_chain();
  const double size = 0.1 * chain.masses[0] * kTwoPi * kShaken_hz;
  const Explained seen = explained(chain, rig_of(chain, kShaken_hz), {.ground_damping = size}, 1);
  ASSERT_TRUE(seen.asked) << told(seen);
  ASSERT_TRUE(names(seen, "damping of mass 1 to ground")) << told(seen);
  EXPECT_EQ(seen.verification.missing.front().unit, "N*s/m");
  EXPECT_NEAR(seen.verification.missing.front().value, size, 4 * seen.verification.missing.front().u);
  EXPECT_FALSE(seen.verification.cannot_be_checked.empty()) << "the common scale of the masses of a free chain";
}

TEST(VerificationCauses, NameAMassThatIsOff) {
  for (const Chain& chain : {free_chain(), clamped_chain()})
    for (const double part : {0.9, 1.1}) {
      if (kUnderSanitizer && part < 1.0) continue;  // half a minute each there
      Rig stated = rig_of(chain, kShaken_hz);
      stated.masses[1] *= part;
      const Explained seen = explained(chain, stated, {}, 2);
      ASSERT_TRUE(seen.asked) << told(seen);
      EXPECT_TRUE(names(seen, "mass 2")) << part << ": " << told(seen);
    }
}

// So far off that the fit goes astray: every mistake and term is tried from the start.
TEST(VerificationCauses, NameAMassThatIsFarOff) {
  if (kUnderSanitizer) GTEST_SKIP() << "takes minutes there; NameAMassThatIsOff runs the same code";
  const Chain chain = clamped_chain();
  Rig stated = rig_of(chain, kShaken_hz);
  stated.masses[1] *= 1.3;
  const Explained seen = explained(chain, stated, {}, 2);
  EXPECT_TRUE(names(seen, "mass 2")) << told(seen);
}

TEST(VerificationCauses, NameADelay) {
  const Chain chain = clamped_chain();
  const Explained seen = explained(chain, rig_of(chain, kShaken_hz), {}, 3, 2);
  ASSERT_TRUE(seen.asked) << told(seen);
  EXPECT_TRUE(names(seen, "delay of y2")) << told(seen);
}

TEST(VerificationCauses, NameFriction) {
  const Chain chain = free_chain();
  const double friction = 0.1 * chain.stiffness[0] * kShaken_m;
  const Explained seen = explained(chain, rig_of(chain, kShaken_hz), {.element = 1, .friction = friction}, 4);
  ASSERT_TRUE(seen.asked) << told(seen);
  EXPECT_TRUE(names(seen, "friction in element 1")) << told(seen);
}

TEST(VerificationCauses, AreNoneOfARightRig) {
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(draws(20, 2)); ++seed)
    for (const Chain& chain : {free_chain(), clamped_chain()}) {
      const Explained seen = explained(chain, rig_of(chain, kShaken_hz), {}, 100 + seed);
      EXPECT_TRUE(seen.verification.missing.empty()) << "seed " << seed << ": " << told(seen);
    }
}

// The search is not asked for where the model is consistent; where it is made all the same, it finds nothing.
TEST(VerificationCauses, AreNotFoundWhereThereAreNone) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, kShaken_hz);
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  for (int play = 0; play < draws(10, 2); ++play) {
    FaultyMotion motion(chain, {}, kShaken_m, {{kShaken_hz, 1.0}});
    std::vector<ChannelReadings> readings(rig.channels.size());
    for (int i = 0; i < 600; ++i) {
      const auto state = motion.at(i / kPolled_hz);
      for (std::size_t c = 0; c < readings.size(); ++c) {
        const bool force = rig.channels[c].measures == Quantity::force;
        readings[c].t_ns.push_back(to_ns(i / kPolled_hz));
        readings[c].value.push_back((force ? state.force : state.y[c]) +
                                    2e-3 * kShaken_m * (force ? chain.stiffness.back() : 1.0) * normal(rng));
      }
    }
    const Causes causes = find_causes(rig, readings, to_ns(3.0));
    EXPECT_TRUE(causes.missing.empty()) << causes.missing.front().what;
    EXPECT_EQ(causes.none, "fitted to these readings alone, the chain explains them");
  }
}

}  // namespace
}  // namespace dwell
