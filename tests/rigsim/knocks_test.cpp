// What a knocked rig does is what its drive does plus the free response to each knock.
#include "tests/rigsim/knocks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/rigsim/control.hpp"
#include "tests/rigsim/device.hpp"
#include "tests/rigsim/recording.hpp"

namespace rigsim {
namespace {

constexpr double kRounding = 1e-12;  // m and m/s; motions are of 5 mm and 0.1 m/s
constexpr double kRounding_N = 1e-7;

std::vector<double> reading(Device& device, double t_s) {
  std::vector<double> values(device.channels().size());
  device.read(t_s, values);
  return values;
}

std::vector<Knock> all_until(const std::vector<Knocking>& kinds, std::uint64_t seed, double end_s) {
  Knocker knocker(kinds, seed);
  std::vector<Knock> knocks;
  while (const auto knock = knocker.due(end_s)) knocks.push_back(*knock);
  return knocks;
}

// m y'' + r y' + c y = J δ: y = J / (m ω_d) exp(-δτ) sin ω_d τ.
TEST(RigsimKnocks, OneMassRingsAsItsEquationSaysOnTopOfTheSteadyMotion) {
  Options rig;
  rig.chain = {dwell::Boundary::clamped, {12}, {24000, 8000}, {60, 45}};
  rig.from_steady = true;
  Device knocked(rig), steady(rig);
  const double knock_s = 0.777, impulse = 0.6, m = 12, c = 32000, r = 105, decay = r / (2 * m);
  const double omega = std::sqrt(c / m - decay * decay);
  ASSERT_EQ(knocked.command(knock_s, {"knock", "1", "0.6"}), "");
  for (double t_s = knock_s - 0.1; t_s < 3.0; t_s += 0.0137) {
    const std::vector<double> with = reading(knocked, t_s), without = reading(steady, t_s);
    const double since = t_s - knock_s, size = since < 0 ? 0.0 : impulse / (m * omega) * std::exp(-decay * since);
    const double y = size * std::sin(omega * since), velocity = size * omega * std::cos(omega * since) - decay * y;
    EXPECT_EQ(with[0], without[0]) << t_s;
    EXPECT_NEAR(with[1] - without[1], y, kRounding) << t_s;
    EXPECT_NEAR(with[2] - without[2], 8000 * y + 45 * velocity, kRounding_N) << t_s;
  }
}

// The exact chain, begun anew from its state with one velocity changed at each knock; the drive changes meanwhile.
TEST(RigsimKnocks, RandomKnocksToSeveralMassesAddUpExactly) {
  Options rig;
  rig.knocks = {{1, 0.3, 0.5, 8.0}, {3, -0.2, 1.5, 12.0}};
  Device device(rig);
  const std::vector<Knock> knocks = all_until(rig.knocks, rig.seed, 20.0);
  ASSERT_GT(knocks.size(), 10U);
  dwell::DrivenChain exact(rig.chain, rig.drive, dwell::DrivenChain::Start::rest);
  auto next = knocks.begin();
  const double change_s = 4.0;
  bool changed = false;
  for (double t_s = 0.0; t_s < 16.0; t_s += 0.013) {
    const auto catch_up = [&](double to_s) {
      for (; next != knocks.end() && next->t_s <= to_s; ++next) {
        dwell::ChainMotion motion = exact.at(next->t_s);
        const auto k = static_cast<std::size_t>(next->mass);
        motion.velocity[k] += next->impulse / rig.chain.masses[k - 1];
        exact.set_state(next->t_s, {motion.y.begin() + 1, motion.y.end()},
                        {motion.velocity.begin() + 1, motion.velocity.end()});
      }
    };
    if (!changed && t_s > change_s) {
      changed = true;
      catch_up(change_s);
      dwell::Drive drive = rig.drive;
      drive.amplitude = 0.003;
      exact.set_drive(change_s, drive);
      ASSERT_EQ(device.command(change_s, {"amplitude", "0.003"}), "");
    }
    catch_up(t_s);
    const std::vector<double> values = reading(device, t_s);
    const dwell::ChainMotion& motion = exact.at(t_s);
    for (std::size_t k = 0; k < motion.y.size(); ++k) EXPECT_NEAR(values[k], motion.y[k], kRounding) << t_s;
    EXPECT_NEAR(values[4], motion.ground_force, kRounding_N) << t_s;
  }
}

TEST(RigsimKnocks, ComeAtRandomInstantsInOrderAndNotAfterTheirEnd) {
  const double every_s = 5.0, until_s = 20000.0;
  const std::vector<Knocking> kinds{{2, 0.3, every_s, until_s}, {1, 0.1, 50.0}};
  std::vector<double> gaps;
  double before_s = 0.0, any_s = 0.0;
  long endless = 0;
  for (const Knock& knock : all_until(kinds, 7, 40000.0)) {
    EXPECT_GE(knock.t_s, any_s);
    any_s = knock.t_s;
    if (knock.mass == 1) {
      endless += knock.t_s > until_s;
      continue;
    }
    EXPECT_LE(knock.t_s, until_s);
    gaps.push_back(knock.t_s - before_s);
    before_s = knock.t_s;
  }
  EXPECT_GT(endless, 0);
  // Exponential: mean and standard deviation alike. Four standard deviations of what 4000 gaps scatter.
  const auto count = static_cast<double>(gaps.size());
  double mean = 0.0, square = 0.0;
  for (const double gap : gaps) mean += gap / count, square += gap * gap / count;
  EXPECT_NEAR(count, until_s / every_s, 4 * std::sqrt(until_s / every_s));
  EXPECT_NEAR(std::sqrt(square - mean * mean) / mean, 1.0, 4 / std::sqrt(count));
}

TEST(RigsimKnocks, ComeAtTheSameInstantsWithTheSameSeed) {
  const std::vector<Knocking> kinds{{1, 0.3, 2.0}};
  const std::vector<Knock> first = all_until(kinds, 1, 20.0), again = all_until(kinds, 1, 20.0);
  ASSERT_FALSE(first.empty());
  ASSERT_EQ(first.size(), again.size());
  EXPECT_EQ(first[0].t_s, again[0].t_s);
  EXPECT_NE(first[0].t_s, all_until(kinds, 2, 20.0).at(0).t_s);
}

TEST(RigsimKnocks, LeaveTheNoiseOfTheSameSeedAsItIs) {
  Options rig;
  rig.from_steady = true;
  const auto difference = [&rig](double noise) {
    Options quiet = rig;
    quiet.faults.noise = noise;
    Options loud = quiet;
    loud.knocks = {{1, 0.3, 0.5}};
    Device without(quiet), with(loud);
    std::vector<double> differences;
    for (double t_s = 0.0; t_s < 2.0; t_s += 0.01)
      differences.push_back(reading(with, t_s)[1] - reading(without, t_s)[1]);
    return differences;
  };
  const std::vector<double> noisy = difference(0.01), clean = difference(0.0);
  for (std::size_t i = 0; i < clean.size(); ++i) EXPECT_NEAR(noisy[i], clean[i], kRounding);
}

TEST(RigsimKnocks, ARegisterRefreshedBeforeTheKnockHoldsWhatWasBefore) {
  Options rig;
  rig.from_steady = true;
  rig.lines = {"refresh all 0.1"};
  Device device(rig);
  dwell::DrivenChain steady(rig.chain, rig.drive, dwell::DrivenChain::Start::steady);
  ASSERT_EQ(device.command(0.15, {"knock", "2", "5"}), "");
  EXPECT_NEAR(reading(device, 0.19)[2], steady.at(0.1).y[2], kRounding);
  EXPECT_GT(std::abs(reading(device, 0.2)[2] - steady.at(0.2).y[2]), 1e-3);
}

// A bent chain is integrated: its steps are 1e-7 m off at most (bent_chain_test.cpp).
TEST(RigsimKnocks, AreTheSameInAChainThatIsIntegrated) {
  Options rig;
  rig.knocks = {{1, 0.3, 0.5}, {2, 0.2, 0.7}};
  Options bent = rig;
  bent.bend.side = {{1, 0, 1e-9, 0}};  // as good as none
  Device exact(rig), integrated(bent);
  for (double t_s = 0.0; t_s < 5.0; t_s += 0.0131) {
    const std::vector<double> a = reading(integrated, t_s), b = reading(exact, t_s);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(a[k], b[k], 2e-7) << t_s;
  }
  // Two at one instant, and a look back to before them.
  const std::vector<double> before = reading(integrated, 5.5);
  for (Device* device : {&exact, &integrated})
    for (const char* mass : {"1", "3"}) ASSERT_EQ(device->command(5.6, {"knock", mass, "1"}), "");
  const std::vector<double> a = reading(integrated, 5.65), b = reading(exact, 5.65);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(a[k], b[k], 2e-7);
  EXPECT_NEAR(reading(integrated, 5.5)[2], before[2], kRounding);
}

TEST(RigsimKnocks, AControlLineKnocksARecording) {
  Options rig;
  rig.from_steady = true;
  std::ostringstream with, without;
  const RecordingOptions recording{.duration_s = 1.0, .rate_hz = 100};
  RecordingOptions knocked = recording;
  knocked.script = {"0.5 knock 1 0.5"};
  ASSERT_EQ(write_recording(with, rig, knocked), "");
  ASSERT_EQ(write_recording(without, rig, recording), "");
  const auto half = with.str().find("\n0.5,");
  ASSERT_NE(half, std::string::npos);
  EXPECT_EQ(with.str().substr(0, half), without.str().substr(0, half));
  EXPECT_NE(with.str(), without.str());
}

TEST(RigsimKnocks, RefuseAMassThatIsNotThere) {
  Device device{Options{}};
  for (const char* line : {"knock", "knock 0 1", "knock 4 1", "knock 1.5 1", "knock 1 hard", "knock 1 1 1"}) {
    const auto answer = device.command(0.0, split_words(line));
    ASSERT_TRUE(answer) << line;
    EXPECT_NE(*answer, "") << line;
  }
  Options rig;
  EXPECT_EQ((Knocking{3, 0.5, 10.0}.fault(rig.chain)), "");
  EXPECT_NE((Knocking{4, 0.5, 10.0}.fault(rig.chain)), "");
  EXPECT_NE((Knocking{1, 0.5, 0.0}.fault(rig.chain)), "");
  EXPECT_NE((Knocking{1, 0.5, 10.0, -1.0}.fault(rig.chain)), "");
  rig.chain = {dwell::Boundary::clamped, {}, {1e4}, {10}};
  EXPECT_NE((Knocking{1, 0.5, 10.0}.fault(rig.chain)), "");
}

}  // namespace
}  // namespace rigsim
