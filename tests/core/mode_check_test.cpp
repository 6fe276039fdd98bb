// What the transient tells of the model: rigs that are not as their files say.
#include "core/chain/mode_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/faulty_motion.hpp"

namespace dwell {
namespace {

constexpr double kDrive_hz = 4.0, kTable = 0.002;

Drive drive_from_rest() {
  Drive drive;
  drive.frequency_hz = kDrive_hz;
  drive.amplitude = kTable;
  return drive;
}

// One dwell of `chain`, described by `rig`, from rest, noise 0.2 % of each channel's amplitude.
Dwell dwell_of(const Chain& chain, const Rig& rig, std::uint64_t seed,
               const std::function<void(Record&, double)>& alter = {}) {
  const auto steady = steady_response(chain, 2 * M_PI * kDrive_hz, kTable);
  Sampling sampling{.rate_hz = 200, .skew_s = 5e-4, .sigma = {}};
  for (const Channel& channel : rig.channels)
    sampling.sigma.push_back(2e-3 * (channel.measures == Quantity::force
                                         ? std::abs(steady.F)
                                         : std::abs(steady.Y[static_cast<std::size_t>(channel.at)])));
  Bench bench(chain, rig, drive_from_rest(), DrivenChain::Start::rest, sampling, seed);
  bench.alter = alter;
  bench.run(60);
  bench.finish();
  EXPECT_EQ(bench.dwells.size(), 1u);
  return bench.dwells.empty() ? Dwell{} : bench.dwells.front();
}

Chain lightly_damped_chain() { return {Boundary::clamped, {12.5, 8.0}, {24000, 15000, 9000}, {20, 15, 10}}; }

// Whether the doubt stands, names the mode's frequency and `cause`.
void expect_doubt(const Dwell& dwell, const std::string& cause) {
  EXPECT_TRUE(std::isfinite(dwell.settled_s));
  EXPECT_FALSE(trustworthy(dwell));
  ASSERT_EQ(dwell.doubts.size(), 1u);
  EXPECT_NE(dwell.doubts[0].what.find("mode at "), std::string::npos) << dwell.doubts[0].what;
  EXPECT_NE(dwell.doubts[0].what.find(cause), std::string::npos) << dwell.doubts[0].what;
}

TEST(ModeCheck, ARigThatIsAsItsFileSaysIsNotDoubted) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    for (const Chain& chain : {lightly_damped_chain(), free_chain()}) {
      const Dwell dwell = dwell_of(chain, rig_of(chain, kDrive_hz), seed);
      EXPECT_TRUE(trustworthy(dwell));
      for (const Doubt& doubt : dwell.doubts) ADD_FAILURE() << doubt.what;
    }
}

TEST(ModeCheck, AMassStatedTenPercentTooLargeIsDoubtedAndNamed) {
  const Chain chain = lightly_damped_chain();
  Rig rig = rig_of(chain, kDrive_hz);
  rig.masses[0] *= 1.1;
  expect_doubt(dwell_of(chain, rig, 1), "mass 1 stated ");
}

TEST(ModeCheck, AMassWithinItsStatedUncertaintyIsNotDoubted) {
  const Chain chain = lightly_damped_chain();
  Rig rig = rig_of(chain, kDrive_hz);
  rig.masses[0] *= 1.1;
  rig.mass_u = {0.1 * rig.masses[0], 1e-3};
  EXPECT_TRUE(dwell_of(chain, rig, 1).doubts.empty());
}

TEST(ModeCheck, AChannelWhoseScaleIsOffIsDoubtedAndNamed) {
  const Chain chain = lightly_damped_chain();
  const auto by_two_percent = [](Record& record, double) {
    if (record.channel == 1) record.value *= 1.02;
  };
  expect_doubt(dwell_of(chain, rig_of(chain, kDrive_hz), 1, by_two_percent), "y1 reading ");
}

// inch for cm, cm for inch, lbf for kgf: the motion is plausible, and so are the coefficients.
TEST(ModeCheck, AChannelInAnotherUnitThanStatedIsDoubtedAndNamed) {
  struct Mistake {
    std::uint16_t channel;
    double factor;
    const char* name;
  };
  for (const Mistake& mistake : {Mistake{1, 2.54, "y1"},
                                 {1, 1 / 2.54, "y1"},
                                 {2, 2.54, "y2"},
                                 {3, 2.2046, "reaction"},
                                 {3, 4.4482, "reaction"},
                                 {3, 1 / 4.4482, "reaction"}}) {
    const std::string what = std::string(mistake.name) + " times " + std::to_string(mistake.factor);
    const Chain chain = lightly_damped_chain();
    const Dwell dwell = dwell_of(chain, rig_of(chain, kDrive_hz), 1, [&](Record& record, double) {
      if (record.channel == mistake.channel) record.value *= mistake.factor;
    });
    EXPECT_FALSE(trustworthy(dwell)) << what;
    std::string said;
    for (const Doubt& doubt : dwell.doubts) said += doubt.what + "\n";
    for (const ElementEstimate& element : dwell.elements) said += element.reason + "\n";
    EXPECT_NE(said.find(mistake.name), std::string::npos) << what << ": " << said;
  }
}

TEST(ModeCheck, AChannelThreeTenthsOfAMillisecondLateIsDoubtedAndNamed) {
  const Chain chain = clamped_chain();
  Rig rig = rig_of(chain, kDrive_hz);
  rig.channels[1].delay_s = -3e-4;
  expect_doubt(dwell_of(chain, rig, 1), "y1 0.3");
}

TEST(ModeCheck, AChannelTwoMillisecondsLateIsDoubtedAndNamed) {
  const Chain chain = lightly_damped_chain();
  Rig rig = rig_of(chain, kDrive_hz);
  rig.channels[1].delay_s = -2e-3;
  expect_doubt(dwell_of(chain, rig, 1), "y1 2.1 ms late");
}

// Then the steady motion makes the chain so damped that it has no natural oscillation at all; the data show one.
TEST(ModeCheck, ALateChannelOfOneFreeMassIsDoubtedThoughTheChainDoesNotOscillateByItself) {
  for (const double damping : {50.0, 20.0, 8.0})
    for (const double late_s : {1.25e-3, 2.5e-3, 5e-3}) {
      const Chain chain{Boundary::free, {3}, {36000}, {damping}};
      Rig rig = rig_of(chain, kDrive_hz);
      rig.channels[1].delay_s = -late_s;
      const Dwell dwell = dwell_of(chain, rig, 1);
      EXPECT_FALSE(trustworthy(dwell)) << damping << " " << late_s;
      EXPECT_GE(dwell.doubts.size(), 1u);
    }
}

TEST(ModeCheck, ASpringFromTheMassToGroundThatTheFileDoesNotHaveIsDoubtedAndNamed) {
  const Chain chain{Boundary::clamped, {12.5}, {24000, 400}, {20, 1}};
  Rig rig = rig_of(chain, kDrive_hz);
  rig.boundary = Boundary::free;
  rig.channels.pop_back();
  expect_doubt(dwell_of(chain, rig, 1), "N/m from mass 1 to ground");
}

TEST(ModeCheck, ASpringBetweenTwoMassesThatTheFileDoesNotHaveIsDoubtedAndNamed) {
  const Chain chain{Boundary::clamped, {12.5, 8.0, 5.0}, {24000, 15000, 9000, 12000}, {20, 15, 10, 12}};
  const Rig rig = rig_of(chain, kDrive_hz);
  Faults beside;
  beside.mass = 1;
  beside.joined_to = 3;
  beside.table_stiffness = 1500;
  FaultyMotion motion(chain, beside, kTable, {{kDrive_hz, 1.0}});
  const auto steady = steady_response(chain, 2 * M_PI * kDrive_hz, kTable);
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  Pipeline pipeline(rig);
  for (int i = 0; i < 200 * 60; ++i) {
    const FaultyMotion::State now = motion.at(i / 200.0);
    for (std::uint16_t c = 0; c < 5; ++c) {
      const double size = c == 4 ? std::abs(steady.F) : std::abs(steady.Y[c]);
      Record record;
      record.t_ns = 5'000'000LL * i;
      record.channel = c;
      record.value = (c == 4 ? now.force : now.y[c]) + 2e-3 * size * normal(rng);
      pipeline.push(record);
    }
  }
  pipeline.finish();
  const Dwell& dwell = pipeline.completed();
  EXPECT_TRUE(std::isfinite(dwell.settled_s));
  EXPECT_FALSE(trustworthy(dwell));
  std::string said;
  for (const Doubt& doubt : dwell.doubts) said += doubt.what + "\n";
  EXPECT_NE(said.find("mode at "), std::string::npos) << said;
  EXPECT_NE(said.find(" N/m from mass 1 to mass 3"), std::string::npos) << said;
}

// Elements 2 and 3 come out negative. Of elements 1 and 4 alone a spring that is not there explains all.
TEST(ModeCheck, OfTwoSwappedChannelsNoConnectionIsNamedThatDoesNotExplainTheNegativeElementsToo) {
  const Chain chain{Boundary::clamped, {12.0, 8.0, 5.0}, {24000, 8000, 6000, 8000}, {60, 45, 30, 40}};
  const Dwell dwell = dwell_of(chain, rig_of(chain, kDrive_hz), 1, [](Record& reading, double) {
    if (reading.channel == 1 || reading.channel == 2) reading.channel = 3 - reading.channel;
  });
  std::string all;
  for (const Doubt& doubt : dwell.doubts) all += doubt.what + "\n";
  EXPECT_NE(all.find("mode at "), std::string::npos) << all;
  EXPECT_NE(all.find("which no passive element has"), std::string::npos) << all;
  EXPECT_EQ(all.find("a spring of"), std::string::npos) << all;
}

TEST(ModeCheck, ADwellBegunWithoutATransientHasNothingToCompare) {
  const Chain chain = lightly_damped_chain();
  Rig rig = rig_of(chain, kDrive_hz);
  rig.masses[0] *= 1.1;
  Bench bench(chain, rig, drive_from_rest(), DrivenChain::Start::steady,
              {.rate_hz = 200, .sigma = {2e-6, 2e-6, 2e-6, 0.01}});
  bench.run(30);
  bench.finish();
  ASSERT_EQ(bench.dwells.size(), 1u);
  EXPECT_TRUE(bench.dwells[0].doubts.empty());
}

}  // namespace
}  // namespace dwell
