// A run's own records give its results again, bit for bit.
#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include "daemon/estimate/measurement.hpp"
#include "tests/daemon/dwell_bits.hpp"
#include "tests/daemon/simulated_session.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell {
namespace {

using test::CollectingSink;
using test::DwellBits;
using test::SimulatedSession;

// What the replays have been through, so that none of it goes untested.
struct Covered {
  std::size_t runs = 0, results = 0, finals = 0, states = 0, with_elements = 0, busy = 0, by_operator = 0,
              reaching_back = 0;
};

// Feeds the run to a new pipeline and compares each result at its position.
void replay(const Rig& rig, const CollectingSink::Run& run, Covered& covered) {
  std::vector<std::shared_ptr<const Dwell>> ended;
  std::vector<std::tuple<std::uint64_t, State, State>> states;
  std::uint64_t position = 0;
  State shown = State::idle;
  Measurement again(rig, KeptDwells(1000, 100'000'000), [&](const RunEvent& event) {
    if (event.kind == RunEvent::Kind::dwell_finished) return ended.push_back(event.dwell);
    const State before = std::exchange(shown, event.dwell->state);
    if (before != shown && position > run.begins + 1 && position < run.records.size())
      states.emplace_back(position, before, shown);
  });
  std::size_t next = 0, told = 0;
  bool finished = false;
  for (std::size_t i = 0; i < run.records.size(); ++i) {
    position = i + 1;
    again.take(run.records[i]);
    covered.busy += again.busy();
    for (; next < run.results.size() && run.results[next].position == i + 1; ++next) {
      const CollectingSink::Result& stored = run.results[next];
      if (stored.final && told == ended.size() && i + 1 == run.records.size() && !std::exchange(finished, true))
        again.finish();
      ASSERT_TRUE(stored.final || i + 1 < run.records.size()) << "at the end dwells have ended";
      ASSERT_TRUE(stored.final ? told < ended.size() : !again.busy()) << "at position " << i + 1;
      const Dwell& dwell = stored.final ? *ended[told++] : again.current();
      ASSERT_EQ(DwellBits::of(dwell), DwellBits::of(*stored.dwell)) << "at position " << i + 1;
      covered.with_elements += !dwell.elements.empty();
    }
  }
  if (!finished) again.finish();
  EXPECT_EQ(states, run.states) << "changes of state stand where they came";
  covered.states += states.size();
  EXPECT_EQ(next, run.results.size()) << "every result has a position in its run";
  EXPECT_EQ(told, ended.size()) << "no dwell ended that was not told of";
  ++covered.runs;
  covered.results += run.results.size();
  covered.finals += ended.size();
}

void replay_all(const SimulatedSession& session, Covered& covered) {
  for (const CollectingSink::Run& run : session.sink.runs()) {
    ASSERT_TRUE(run.ended);
    ASSERT_TRUE(is_edge(run.records.front(), RunEdge::armed));
    ASSERT_TRUE(is_edge(run.records[run.begins], RunEdge::begins));
    covered.by_operator += run.records[run.begins].channel != 0;
    covered.reaching_back += run.records[run.begins].t_ns - run.records.front().t_ns >= 10 * kSecond_ns;
    replay(session.rig, run, covered);
    if (testing::Test::HasFatalFailure()) return;
  }
}

Chain random_chain(std::mt19937_64& random, int masses) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Chain chain{unit(random) < 0.3 ? Boundary::clamped : Boundary::free, {}, {}, {}};
  for (int k = 0; k < masses; ++k) chain.masses.push_back(1.0 + 9.0 * unit(random));
  for (int k = 0; k < chain.element_count(); ++k) {
    const double natural = 2 * std::numbers::pi * (6.0 + 20.0 * unit(random));
    chain.stiffness.push_back(5.0 * natural * natural);
    chain.damping.push_back(2 * (0.01 + 0.1 * unit(random)) * 5.0 * natural);
  }
  return chain;
}

// Anything that can happen to a session, in any order.
void happen(SimulatedSession& session, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::uint16_t request = 0;
  for (int i = 0; i < 14; ++i) {
    switch (random() % 10) {
      case 0:
      case 1:
      case 2:
        session.drive(2e-3 * (0.5 + unit(random)));
        break;
      case 3:
      case 4:
        session.drive(0.0);
        break;
      case 5:
        (void)session.estimator->rearm(++request);
        break;
      case 6:
        session.interlock(unit(random) < 0.6);
        break;
      case 7:
        session.silence(unit(random) < 0.5 ? -1 : static_cast<int>(random() % session.rig.channels.size()));
        break;
      case 8:
        (void)session.estimator->begin_run(++request);
        break;
      default:
        (void)session.estimator->end_run(++request);
    }
    session.go_on(unit(random) < 0.3 ? 12.0 + 10.0 * unit(random) : 6.0 * unit(random));
  }
  session.finish();
}

TEST(RunReplay, ItsRecordsGiveItsResultsAgainWhateverHappens) {
  constexpr unsigned kSessions = draws(40, 8);
  Covered covered;
  for (std::uint64_t seed = 1; seed <= kSessions; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const int masses = 1 + static_cast<int>(random() % 3);
    const double drive_hz = 4.0 + static_cast<double>(random() % 700) * 0.01;
    SimulatedSession session(random_chain(random, masses), drive_hz, 1e-6, 1 + static_cast<int>(random() % 3), seed);
    happen(session, random);
    replay_all(session, covered);
    ASSERT_FALSE(HasFatalFailure());
  }
  EXPECT_GT(covered.runs, 2 * kSessions);
  EXPECT_GT(covered.results, 25 * kSessions);
  EXPECT_GT(covered.finals, 5 * kSessions / 2);
  EXPECT_GT(covered.with_elements, 15 * kSessions / 2);
  EXPECT_GT(covered.by_operator, kSessions / 2);
  EXPECT_GT(covered.reaching_back, kSessions / 4);
  EXPECT_GT(covered.states, 2 * kSessions);
}

// A result may be due between the last sample and the request to stop.
TEST(RunReplay, OfRunsThatAnOperatorStopsBetweenTwoSamples) {
  Covered covered;
  SimulatedSession session({Boundary::free, {5.0}, {20'000.0}, {60.0}}, 5.0, 1e-6, 2, 1, true, nullptr, 0.002);
  session.drive(2e-3);
  std::uint16_t request = 0;
  for (int run = 0; run < 20; ++run) {
    (void)session.estimator->begin_run(++request);
    session.go_on(0.5 + 0.0013 * run);
    (void)session.estimator->end_run(++request);
    session.go_on(0.02);
  }
  session.finish();
  replay_all(session, covered);
  EXPECT_EQ(covered.by_operator, 20U);
}

// The pipeline before it has seen the fault, its own has not.
TEST(RunReplay, OfARunThatBeginsAtAFault) {
  Covered covered;
  SimulatedSession session({Boundary::free, {5.0}, {20'000.0}, {60.0}}, 5.0, 1e-6, 2, 1);
  session.go_on(3.0);
  session.silence(0);
  session.go_on(5.0);
  EXPECT_EQ(session.latest().dwell.state, State::fault);
  (void)session.estimator->begin_run(1);
  session.go_on(5.0);
  session.finish();
  ASSERT_FALSE(session.sink.runs().back().states.empty());
  EXPECT_EQ(std::get<1>(session.sink.runs().back().states.front()), State::idle);
  EXPECT_EQ(std::get<2>(session.sink.runs().back().states.front()), State::fault);
  replay_all(session, covered);
}

// The drive goes on after its run was stopped, rests, and begins the next run. That one reaches back to the stop.
TEST(RunReplay, OfARunThatReachesBackToTheEndOfADwellBeforeIt) {
  Covered covered;
  SimulatedSession session({Boundary::free, {5.0}, {20'000.0}, {60.0}}, 5.0, 1e-6, 2, 1);
  session.drive(2e-3);
  session.go_on(8.0);
  (void)session.estimator->end_run(1);
  session.go_on(4.0);
  session.drive(0.0);
  session.go_on(13.0);
  session.drive(2e-3);
  session.go_on(8.0);
  session.finish();
  ASSERT_EQ(session.sink.runs().size(), 2u);
  const CollectingSink::Run second = session.sink.runs().back();
  ASSERT_FALSE(second.results.empty());
  EXPECT_TRUE(second.results.front().final);
  EXPECT_LT(second.results.front().position, second.begins) << "a dwell ended before the run began";
  replay_all(session, covered);
}

// A rig so large that its fits take many pushes: results wait for the work, and a stop ends it at once.
TEST(RunReplay, OfARigWhoseFitsAreDoneInSlices) {
  Covered covered;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    std::mt19937_64 random(seed);
    SimulatedSession session(random_chain(random, 8), 7.3, 1e-7, 10, seed);
    session.go_on(2.0);
    session.drive(1e-3);
    session.go_on(4.0 + static_cast<double>(seed));
    (void)session.estimator->begin_run(1);
    session.go_on(5.3);
    (void)session.estimator->end_run(2);
    session.go_on(1.0);
    session.finish();
    replay_all(session, covered);
    ASSERT_FALSE(HasFatalFailure());
  }
  EXPECT_GT(covered.busy, 1000u) << "records during a long piece of work";
  EXPECT_EQ(covered.runs, 6u);
}

TEST(RunReplay, OfASessionThatIsOneRun) {
  std::mt19937_64 random(5);
  SimulatedSession session(random_chain(random, 2), 6.0, 1e-6, 2, 5, false);
  session.drive(1e-3);
  session.go_on(12.0);
  session.drive(0.0);
  session.go_on(15.0);
  session.finish();
  Covered covered;
  replay_all(session, covered);
  EXPECT_EQ(covered.runs, 1u);
  EXPECT_EQ(covered.finals, 1u);
}

}  // namespace
}  // namespace dwell
