// The pipeline in slices: the same dwells to the bit as in one piece, and no push that does more than it may.
#include "core/dwell/paced_pipeline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/model/driven_chain.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kPacedDrive_hz = 10.0, kRate_hz = 500.0;

// A chain of twelve masses from rest, every channel at the same instants: its fits are long.
struct LargeRig {
  std::mt19937_64 random{3};
  Chain chain = damped();
  Rig rig = rig_of(chain, kPacedDrive_hz);

  Chain damped() {
    Chain drawn = random_chain(random, 12, Boundary::free, kPacedDrive_hz);
    for (double& r : drawn.damping) r *= 5;
    return drawn;
  }

  [[nodiscard]] std::vector<Record> stream(double seconds) {
    std::normal_distribution<double> normal;
    DrivenChain motion(chain, {.frequency_hz = kPacedDrive_hz, .amplitude = 2e-3, .ramp_s = 0.1},
                       DrivenChain::Start::rest);
    std::vector<Record> records;
    for (int i = 0; i < seconds * kRate_hz; ++i) {
      const ChainMotion& now = motion.at(i / kRate_hz);
      for (std::size_t c = 0; c < rig.channels.size(); ++c)
        records.push_back({.t_ns = std::llround(1e9 * i / kRate_hz),
                           .value = now.y[c] + 1e-6 * normal(random),
                           .channel = static_cast<std::uint16_t>(c)});
      // An operator begins anew in the middle.
      if (i == seconds * kRate_hz / 2)
        records.push_back(
            {.t_ns = records.back().t_ns, .kind = Kind::action, .flags = static_cast<std::uint8_t>(Action::rearm)});
    }
    return records;
  }
};

// All that a dwell says in numbers.
std::vector<double> numbers(const Dwell& dwell) {
  std::vector<double> all = {dwell.start_s, dwell.settled_s,          dwell.verdict_s,     dwell.end_s,
                             dwell.t_ref_s, dwell.frequency_hz.value, dwell.frequency_hz.u};
  for (const ElementEstimate& element : dwell.elements)
    for (const Coefficient& c : {element.stiffness, element.damping}) all.insert(all.end(), {c.value, c.u, c.U95});
  all.insert(all.end(), dwell.covariance.begin(), dwell.covariance.end());
  return all;
}

void expect_same(const Dwell& a, const Dwell& b) {
  const std::vector<double> of_a = numbers(a), of_b = numbers(b);
  ASSERT_EQ(of_a.size(), of_b.size());
  for (std::size_t i = 0; i < of_a.size(); ++i)
    EXPECT_TRUE(of_a[i] == of_b[i] || (std::isnan(of_a[i]) && std::isnan(of_b[i]))) << i;
  EXPECT_EQ(a.warnings, b.warnings);
}

TEST(PacedPipeline, GivesTheSameDwellsToTheBitAsWorkInOnePiece) {
  LargeRig large;
  const std::vector<Record> stream = large.stream(24);
  Pipeline whole(large.rig);
  PacedPipeline paced(large.rig);
  std::vector<Dwell> of_whole, of_paced;
  std::size_t waited = 0;
  double overdrawn = 0.0;
  for (const Record& record : stream) {
    if (whole.push(record) & kCompleted) of_whole.push_back(whole.completed());
    if (paced.push(record) & kCompleted) of_paced.push_back(paced.pipeline().completed());
    waited = std::max(waited, paced.waiting());
    overdrawn = std::max(overdrawn, paced.overdrawn());
  }
  if (whole.finish() & kCompleted) of_whole.push_back(whole.completed());
  for (std::uint8_t changes = paced.flush(); changes != kNothing; changes = paced.flush())
    if (changes & kCompleted) of_paced.push_back(paced.pipeline().completed());
  if (paced.finish() & kCompleted) of_paced.push_back(paced.pipeline().completed());
  EXPECT_GT(waited, 10u) << "nothing was done in slices";
  EXPECT_LT(overdrawn, PacedPipeline::kAtOnce);
  ASSERT_EQ(of_whole.size(), 2u);
  ASSERT_EQ(of_paced.size(), 2u);
  EXPECT_FALSE(std::isnan(of_whole[1].settled_s));
  for (std::size_t i = 0; i < 2; ++i) expect_same(of_whole[i], of_paced[i]);
}

TEST(PacedPipeline, CountsASampleAsTakenWhenThePipelineHasIt) {
  LargeRig large;
  const std::vector<Record> stream = large.stream(12);
  PacedPipeline paced(large.rig);
  std::uint64_t pushed = 0;
  for (const Record& record : stream) {
    paced.push(record);
    pushed += record.kind == Kind::sample;
    std::uint64_t taken = 0;
    for (std::size_t c = 0; c < large.rig.channels.size(); ++c) taken += paced.taken(c);
    // The oldest that waits may be in work, and then is taken already; an action is no sample.
    ASSERT_LE(taken, pushed);
    ASSERT_GE(taken + paced.waiting(), pushed);
  }
  while (paced.flush() != kNothing) {
  }
  EXPECT_EQ(paced.waiting(), 0u);
}

// A pipeline amid a fit, and the instant of the newest record.
struct Amid {
  LargeRig large;
  PacedPipeline paced{large.rig};
  std::int64_t t_ns = 0;

  Amid() {
    for (const Record& record : large.stream(12)) {
      paced.push(record);
      t_ns = record.t_ns;
      if (paced.busy() && record.t_ns > 2'000'000'000) break;
    }
  }
  void tick(std::int64_t by_ns) {
    t_ns += by_ns;
    paced.push({.t_ns = t_ns, .kind = Kind::tick});
  }
};

TEST(PacedPipeline, WhereTheStreamStandsStillNoWorkIsDoneAndTicksLetItGoOn) {
  Amid amid;
  ASSERT_TRUE(amid.paced.busy());
  const std::size_t waiting = amid.paced.waiting();
  for (std::size_t i = 1; i <= 100; ++i) {
    amid.tick(0);
    ASSERT_EQ(amid.paced.waiting(), waiting + i);
  }
  for (int i = 0; i < 1000 && amid.paced.waiting() > 0; ++i) amid.tick(10'000'000);
  EXPECT_EQ(amid.paced.waiting(), 0u);
}

TEST(PacedPipeline, TheInterlockDoesNotWaitForAFit) {
  for (const double level : {1.0, 0.0}) {
    Amid amid;
    ASSERT_TRUE(amid.paced.busy());
    const Record edge{
        .t_ns = amid.t_ns, .value = level, .channel = static_cast<std::uint16_t>(Line::interlock), .kind = Kind::edge};
    std::uint8_t changes = amid.paced.push(edge);
    // One Change a push; then the next is let through.
    for (int i = 0; i < 3 && amid.paced.waiting() > 0; ++i) {
      const Record same{.t_ns = amid.t_ns, .kind = Kind::tick};
      changes |= amid.paced.push(same);
    }
    EXPECT_FALSE(amid.paced.busy());
    EXPECT_EQ(amid.paced.pipeline().state() == State::idle, level == 0.0);
    EXPECT_TRUE(level != 0.0 || (changes & kStateChanged) != 0);
  }
}

TEST(PacedPipeline, AnInstantThatIsNoneOrNotInOrderChangesNothing) {
  Amid amid;
  for (const std::int64_t t_ns : {INT64_MIN, std::int64_t{0}, INT64_MAX}) {
    amid.paced.push({.t_ns = t_ns, .kind = Kind::tick});
    amid.paced.push({.t_ns = t_ns, .value = 1.0, .channel = 60000, .kind = Kind::sample});
  }
  for (int i = 0; i < 1000 && amid.paced.waiting() > 0; ++i) amid.tick(10'000'000);
  EXPECT_EQ(amid.paced.waiting(), 0u);
}

TEST(PacedPipeline, MoreRecordsThanFindRoomWaitForTheWork) {
  Amid amid;
  const std::size_t room = std::size_t{13} << 15;
  for (std::size_t i = 0; i < room + 10; ++i) {
    amid.tick(0);
    ASSERT_LE(amid.paced.waiting(), room);
  }
  EXPECT_LT(amid.paced.waiting(), room) << "it shrinks again";
}

TEST(PacedPipeline, TheSameStreamIsToldAtTheSameRecords) {
  LargeRig large;
  const std::vector<Record> stream = large.stream(24);
  std::vector<std::size_t> told[2];
  for (std::vector<std::size_t>& at : told) {
    PacedPipeline paced(large.rig);
    for (std::size_t i = 0; i < stream.size(); ++i)
      if (paced.push(stream[i]) != kNothing) at.push_back(i);
  }
  EXPECT_GE(told[0].size(), 3u);
  EXPECT_EQ(told[0], told[1]);
}

}  // namespace
}  // namespace dwell
