// Records taken together give what they give one by one, to the bit and at the same place of the stream.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "daemon/estimate/run_cycle.hpp"
#include "tests/daemon/dwell_bits.hpp"
#include "tests/daemon/simulated_session.hpp"

namespace dwell {
namespace {

using test::CollectingSink;
using test::DwellBits;
using test::SimulatedSession;

// Two dwells of one run, an interruption by the operator, and a scan that comes late.
std::vector<Record> stream_of(SimulatedSession& session) {
  session.go_on(12.0);
  session.drive(1e-3);
  session.go_on(8.0);
  (void)session.estimator->rearm();
  session.go_on(3.0);
  session.late_scan();
  session.go_on(3.0);
  session.drive(0.0);
  session.go_on(14.0);
  session.finish();
  std::vector<Record> stream = session.sink.records;
  std::erase_if(stream, [](const Record& record) { return record.kind == Kind::run; });
  return stream;
}

// What is recorded of the stream where it comes in pieces of 1 … `most` records, at random; 0: one by one.
CollectingSink heard_of(const Rig& rig, const std::vector<Record>& stream, bool bracketed, std::size_t most) {
  CollectingSink sink;
  std::mt19937_64 random(3);
  std::uniform_int_distribution<std::size_t> some(1, std::max<std::size_t>(most, 1));
  std::size_t together = 0;
  {
    RunCycle cycle(rig, {bracketed, &sink, 1.0, false}, KeptDwells(100, 1'000'000), nullptr, [](const RunEvent&) {});
    cycle.set_clocks(stream.front().t_ns, SimulatedSession::kUtc_ns);
    for (std::span<const Record> left(stream); !left.empty();) {
      std::size_t taken = most > 0 ? cycle.take_samples(left.first(std::min(some(random), left.size()))) : 0;
      together += taken;
      if (taken == 0) cycle.take(left[taken++]);
      left = left.subspan(taken);
    }
    cycle.finish(stream.back().t_ns);
  }
  if (most > 0) {
    EXPECT_GT(together, stream.size() / 8) << "a dwell is on for a third of the stream";
  }
  return sink;
}

void expect_same(const CollectingSink& a, const CollectingSink& b) {
  ASSERT_EQ(a.records.size(), b.records.size());
  for (std::size_t i = 0; i < a.records.size(); ++i)
    ASSERT_EQ(std::memcmp(&a.records[i], &b.records[i], sizeof(Record)), 0) << i;
  ASSERT_EQ(a.results.size(), b.results.size());
  for (std::size_t i = 0; i < a.results.size(); ++i) {
    EXPECT_EQ(a.results[i].position, b.results[i].position) << i;
    EXPECT_EQ(a.results[i].after, b.results[i].after) << i;
    EXPECT_EQ(a.results[i].final, b.results[i].final) << i;
    EXPECT_EQ(DwellBits::of(*a.results[i].dwell), DwellBits::of(*b.results[i].dwell)) << i;
  }
  ASSERT_EQ(a.states.size(), b.states.size());
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    EXPECT_EQ(a.states[i].behind, b.states[i].behind) << i;
    EXPECT_EQ(a.states[i].before, b.states[i].before) << i;
    EXPECT_EQ(a.states[i].after, b.states[i].after) << i;
  }
}

TEST(RunCycle, RecordsTakenTogetherGiveTheSameAtTheSamePlace) {
  const double natural = 2 * std::numbers::pi * 12.0;
  SimulatedSession session({Boundary::free, {2.0}, {2.0 * natural * natural}, {2 * 0.1 * 2.0 * natural}}, 10.0, 1e-6, 8,
                           1);
  const std::vector<Record> stream = stream_of(session);
  for (const bool bracketed : {true, false}) {
    const CollectingSink one_by_one = heard_of(session.rig, stream, bracketed, 0);
    ASSERT_GT(one_by_one.results.size(), 10U);
    for (const std::size_t most : {3U, 100U, 5000U})
      expect_same(one_by_one, heard_of(session.rig, stream, bracketed, most));
  }
}

}  // namespace
}  // namespace dwell
