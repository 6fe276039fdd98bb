// When runs begin and end, what they hold, and what is shown meanwhile.
#include "daemon/estimate/run_cycle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/daemon/dwell_bits.hpp"
#include "tests/daemon/simulated_session.hpp"

namespace dwell {
namespace {

using test::CollectingSink;
using test::SimulatedSession;

constexpr double kMoving = 1e-3;  // m, the table's amplitude

Chain one_mass_at_12_hz() {
  const double natural = 2 * std::numbers::pi * 12.0;
  return {Boundary::free, {2.0}, {2.0 * natural * natural}, {2 * 0.1 * 2.0 * natural}};
}

struct RunCycleTest : testing::Test {
  double now_s() const { return 1e-9 * static_cast<double>(session.now_ns - SimulatedSession::kStart_ns); }
  static double at_s(const Record& record) {
    return 1e-9 * static_cast<double>(record.t_ns - SimulatedSession::kStart_ns);
  }
  static EndOfRun why(const CollectingSink::Run& run) { return static_cast<EndOfRun>(run.records.back().value); }
  void accounts_are_exact() {
    for (const ChannelView& channel : session.latest().channels) {
      const Tally& tally = channel.tally;
      EXPECT_EQ(tally.received, tally.used + tally.dropped() + tally.queued);
    }
  }
  // Goes on, looking at the accounts after every turn.
  void go_on(double seconds) {
    for (const double end_s = now_s() + seconds; now_s() < end_s - 1e-6;) {
      session.go_on(0.01);
      accounts_are_exact();
    }
  }

  SimulatedSession session{one_mass_at_12_hz(), 10.0, 1e-6, 2, 1};
};

TEST_F(RunCycleTest, ARunOfTheDriveReachesBackASpanAndEndsASpanAfterTheDrive) {
  session.go_on(47.0);
  EXPECT_FALSE(session.latest().run.on);
  session.drive(kMoving);
  session.go_on(8.0);
  EXPECT_TRUE(session.latest().run.on);
  EXPECT_EQ(session.latest().dwell.state, State::measuring) << session.latest().dwell.settling_reason;
  session.drive(0.0);
  const double stops_s = now_s();
  session.go_on(9.0);
  EXPECT_TRUE(session.latest().run.on) << "the drive may come again";
  session.go_on(4.0);
  EXPECT_FALSE(session.latest().run.on);
  session.finish();

  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 1u);
  const double birth_s = at_s(runs[0].records.front()), begins_s = at_s(runs[0].records[runs[0].begins]);
  EXPECT_LT(birth_s, begins_s - 10.0);
  EXPECT_GT(birth_s, begins_s - 20.1);
  EXPECT_NEAR(begins_s, 47.0, 0.6) << "the drive is recognized";
  EXPECT_NEAR(at_s(runs[0].records.back()), stops_s + 10.0, 1.5);
  EXPECT_EQ(why(runs[0]), EndOfRun::drive_stopped);
  EXPECT_EQ(runs[0].records.back().channel, 0u) << "nobody asked for it";
  const auto finals = std::count_if(runs[0].results.begin(), runs[0].results.end(), [](auto& r) { return r.final; });
  EXPECT_EQ(finals, 1);
}

TEST_F(RunCycleTest, BeforeTheFirstSpanIsOverARunBeginsWithWhatThereIs) {
  session.go_on(3.0);
  session.drive(kMoving);
  session.go_on(5.0);
  session.finish();
  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_LT(at_s(runs[0].records.front()), 0.2);
  EXPECT_EQ(why(runs[0]), EndOfRun::service_stops);
}

TEST_F(RunCycleTest, APauseShorterThanASpanBelongsToTheRun) {
  session.drive(kMoving);
  session.go_on(6.0);
  session.drive(0.0);
  session.go_on(8.0);
  session.drive(kMoving);
  session.go_on(6.0);
  EXPECT_EQ(session.latest().dwell.index, 2);
  session.finish();
  EXPECT_EQ(session.sink.runs().size(), 1u);
}

TEST_F(RunCycleTest, EachRunHasItsOwnDwellsAndItsOwnTime) {
  for (int run = 1; run <= 3; ++run) {
    session.drive(kMoving);
    session.go_on(6.0);
    const Snapshot& on = session.latest();
    EXPECT_EQ(on.run.number, static_cast<std::uint32_t>(run));
    EXPECT_EQ(on.dwell.index, 1);
    EXPECT_TRUE(on.finished->empty());
    EXPECT_EQ(on.earlier.dwell != nullptr, run > 1) << "the last dwell of the run before is known all the same";
    session.drive(0.0);
    session.go_on(25.0);
    const Snapshot& after = session.latest();
    ASSERT_EQ(after.finished->size(), 1u) << "they stay to be read until the next run begins";
    EXPECT_EQ(after.finished->front()->index, 1);
    const double zero_s =
        1e-9 * static_cast<double>(after.start_utc_ns - SimulatedSession::kUtc_ns - SimulatedSession::kStart_ns);
    EXPECT_NEAR(zero_s + after.finished->front()->start_s, 31.0 * (run - 1), 0.5) << "t = 0 is that of its run";
  }
}

TEST_F(RunCycleTest, AnOperatorsRunBeginsWhereItIsAskedForAndEndsWithStopAlone) {
  go_on(15.0);
  ASSERT_TRUE(session.estimator->begin_run(7));
  go_on(1.0);
  EXPECT_TRUE(session.latest().run.on);
  EXPECT_TRUE(session.latest().run.by_operator);
  session.drive(kMoving);
  go_on(5.0);
  session.drive(0.0);
  go_on(40.0);
  EXPECT_TRUE(session.latest().run.on) << "the drive has been idle for long";
  ASSERT_TRUE(session.estimator->end_run(8));
  go_on(1.0);
  EXPECT_FALSE(session.latest().run.on);
  EXPECT_FALSE(session.latest().run.held) << "the drive rests already";
  session.finish();
  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].records[runs[0].begins].channel, 7u);
  EXPECT_EQ(runs[0].records[runs[0].begins].t_ns, runs[0].records.front().t_ns) << "it has no time before it";
  EXPECT_EQ(runs[0].records.back().channel, 8u);
  EXPECT_EQ(why(runs[0]), EndOfRun::by_operator);
}

TEST_F(RunCycleTest, StartEndsTheDrivesRunAndBeginsAnotherInTheSamePlace) {
  session.drive(kMoving);
  go_on(6.0);
  ASSERT_TRUE(session.estimator->begin_run(1));
  go_on(6.0);
  EXPECT_EQ(session.latest().run.number, 2u);
  EXPECT_EQ(session.latest().dwell.state, State::measuring) << "the new pipeline has found the drive";
  EXPECT_EQ(session.latest().dwell.index, 1);
  session.finish();
  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(why(runs[0]), EndOfRun::by_operator);
  EXPECT_EQ(runs[0].records.back().channel, 1u);
  EXPECT_EQ(runs[0].records.back().t_ns, runs[1].records.front().t_ns);
  const auto samples = [](const CollectingSink::Run& run) {
    return std::count_if(run.records.begin(), run.records.end(), [](auto& r) { return r.kind == Kind::sample; });
  };
  EXPECT_EQ(static_cast<std::uint64_t>(samples(runs[0]) + samples(runs[1])),
            session.latest().channels[0].tally.received + session.latest().channels[1].tally.received);
}

TEST_F(RunCycleTest, AfterAStopNoRunBeginsBeforeTheDriveHasRested) {
  session.drive(kMoving);
  go_on(6.0);
  ASSERT_TRUE(session.estimator->end_run(1));
  go_on(45.0);
  const Snapshot held = session.latest();
  EXPECT_FALSE(held.run.on);
  EXPECT_TRUE(held.run.held);
  EXPECT_EQ(held.dwell.state, State::complete) << "what the run has found stays in view";
  EXPECT_EQ(held.dwell.ended_by, EndedBy::end);
  EXPECT_FALSE(held.dwell.elements.empty());
  EXPECT_NE(held.dwell.settling_reason.find("the run was stopped"), std::string::npos) << held.dwell.settling_reason;
  EXPECT_EQ(held.finished->size(), 1u);
  session.drive(0.0);
  go_on(25.0);
  EXPECT_FALSE(session.latest().run.held);
  EXPECT_EQ(session.latest().dwell.state, State::idle);
  session.drive(kMoving);
  go_on(6.0);
  EXPECT_TRUE(session.latest().run.on);
  session.finish();
  EXPECT_EQ(session.sink.runs().size(), 2u);
}

TEST_F(RunCycleTest, StartBeginsARunWhereAStopHoldsTheDrivesBack) {
  session.drive(kMoving);
  go_on(6.0);
  ASSERT_TRUE(session.estimator->end_run(1));
  go_on(3.0);
  ASSERT_TRUE(session.estimator->begin_run(2));
  go_on(6.0);
  EXPECT_TRUE(session.latest().run.on);
  EXPECT_FALSE(session.latest().run.held);
  EXPECT_EQ(session.latest().dwell.state, State::measuring);
}

// A pipeline is born with each start, and recognizes the drive only after some periods.
TEST_F(RunCycleTest, ShortRunsOfAnOperatorDoNotUndoAStop) {
  session.drive(kMoving);
  go_on(6.0);
  ASSERT_TRUE(session.estimator->end_run(1));
  go_on(2.0);
  for (std::uint16_t request = 2; request < 6; request += 2) {
    ASSERT_TRUE(session.estimator->begin_run(request));
    go_on(0.05);
    ASSERT_TRUE(session.estimator->end_run(static_cast<std::uint16_t>(request + 1)));
    go_on(0.05);
  }
  go_on(20.0);
  EXPECT_TRUE(session.latest().run.held);
  EXPECT_FALSE(session.latest().run.on) << "the drive has not rested";
  EXPECT_EQ(session.latest().run.number, 3u) << "the drive's run and the operator's two";
  session.drive(0.0);
  go_on(25.0);
  EXPECT_FALSE(session.latest().run.held);
  session.drive(kMoving);
  go_on(6.0);
  EXPECT_TRUE(session.latest().run.on);
}

TEST_F(RunCycleTest, AShortRunOfAnOperatorHoldsNothingBackWhereTheDriveRested) {
  go_on(15.0);
  ASSERT_TRUE(session.estimator->begin_run(1));
  go_on(0.05);
  ASSERT_TRUE(session.estimator->end_run(2));
  go_on(0.05);
  EXPECT_FALSE(session.latest().run.held);
  session.drive(kMoving);
  go_on(6.0);
  EXPECT_TRUE(session.latest().run.on);
}

TEST_F(RunCycleTest, ARestartMakesAnotherRunOfTheSameSort) {
  ASSERT_TRUE(session.estimator->begin_run(0));
  go_on(1.0);
  EXPECT_FALSE(session.latest().run.on) << "there is nothing to restart";
  session.drive(kMoving);
  go_on(3.0);
  ASSERT_TRUE(session.estimator->begin_run(0));
  go_on(3.0);
  EXPECT_EQ(session.latest().run.number, 2u);
  EXPECT_FALSE(session.latest().run.by_operator);
  ASSERT_TRUE(session.estimator->begin_run(1));
  go_on(3.0);
  ASSERT_TRUE(session.estimator->begin_run(0));
  go_on(3.0);
  EXPECT_EQ(session.latest().run.number, 4u);
  EXPECT_TRUE(session.latest().run.by_operator);
  session.finish();
  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 4u);
  EXPECT_EQ(why(runs[0]), EndOfRun::restarted);
  EXPECT_EQ(why(runs[1]), EndOfRun::by_operator);
  EXPECT_EQ(why(runs[2]), EndOfRun::restarted);
}

TEST_F(RunCycleTest, AStopWithoutARunIsNothing) {
  go_on(5.0);
  ASSERT_TRUE(session.estimator->end_run(1));
  go_on(5.0);
  EXPECT_FALSE(session.latest().run.held);
  session.drive(kMoving);
  go_on(5.0);
  EXPECT_TRUE(session.latest().run.on);
}

TEST_F(RunCycleTest, ADriveThatCannotBeSeenEndsItsRunAfterAMinute) {
  session.drive(kMoving);
  session.go_on(6.0);
  session.silence(0);  // the table's transducer
  session.go_on(55.0);
  EXPECT_TRUE(session.latest().run.on) << "the cable may be plugged in again";
  EXPECT_EQ(session.latest().dwell.state, State::fault);
  session.go_on(8.0);
  EXPECT_FALSE(session.latest().run.on);
  session.finish();
  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(why(runs[0]), EndOfRun::drive_unseen);
}

// A pipeline born late knows what the elder has heard: the records behind its birth say so.
TEST_F(RunCycleTest, ABirthTellsTheStatesThatHold) {
  session.interlock(false);
  session.go_on(1.0);
  session.silence(1);
  session.go_on(35.0);
  int births = 0;
  for (std::size_t i = 0; i + 3 < session.sink.records.size(); ++i) {
    const Record& birth = session.sink.records[i];
    if (!is_edge(birth, RunEdge::armed) || SimulatedSession::kStart_ns + 5 * kSecond_ns > birth.t_ns) continue;
    ++births;
    const Record *const table = &birth + 1, *const mass = &birth + 2, *const interlock = &birth + 3;
    EXPECT_EQ(table->kind, Kind::channel_state);
    EXPECT_EQ(table->flags, static_cast<std::uint8_t>(Fault::none));
    EXPECT_EQ(mass->kind, Kind::channel_state);
    EXPECT_EQ(mass->flags, static_cast<std::uint8_t>(Fault::silent));
    EXPECT_EQ(interlock->kind, Kind::edge);
    EXPECT_EQ(interlock->value, 0.0);
    EXPECT_EQ(interlock->t_ns, birth.t_ns);
  }
  EXPECT_EQ(births, 3);
  // And it heeds them: with the interlock open no run begins, however the table moves.
  session.silence(-1);
  session.drive(kMoving);
  session.go_on(30.0);
  EXPECT_FALSE(session.latest().run.on);
  session.interlock(true);
  session.go_on(5.0);
  EXPECT_TRUE(session.latest().run.on);
}

// To a pipeline that knows them already the states told again are no event.
TEST_F(RunCycleTest, StatesToldAgainChangeNothing) {
  session.interlock(true);
  session.go_on(1.0);
  session.drive(kMoving);
  session.go_on(12.0);
  session.drive(0.0);
  session.go_on(3.0);
  session.finish();
  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 1u);
  const auto dwells = [&](bool told_again) {
    std::string bits;
    int states = 0;
    Measurement measurement(session.rig, KeptDwells(10, 1'000'000), [&](const RunEvent& event) {
      ++states;
      if (event.kind == RunEvent::Kind::dwell_finished) bits += test::DwellBits::of(*event.dwell);
    });
    KnownStates known(session.rig.channels.size());
    std::size_t count = 0;
    for (const Record& record : runs[0].records) {
      known.take(record);
      measurement.take(record);
      if (told_again && ++count % 97 == 0)
        known.tell(record.t_ns, [&](const Record& again) { measurement.take(again); });
    }
    measurement.finish();
    EXPECT_GE(states, 4) << "settling, measuring, the dwell's end, idle";
    return bits + std::to_string(states);
  };
  EXPECT_EQ(dwells(true), dwells(false));
}

TEST_F(RunCycleTest, TheStatesToldMakeAChainWhicheverPipelineIsShown) {
  State state = State::idle;
  const auto follow = [&] {
    for (const RunEvent& event : session.events()) {
      EXPECT_EQ(event.lost, 0u);
      if (event.kind != RunEvent::Kind::state_changed) continue;
      EXPECT_EQ(event.before, state);
      EXPECT_NE(event.dwell->state, state);
      state = event.dwell->state;
    }
  };
  session.go_on(33.0);
  session.silence(0);
  session.go_on(33.0);
  follow();
  EXPECT_EQ(state, State::fault);
  session.silence(-1);
  session.drive(kMoving);
  session.go_on(6.0);
  (void)session.estimator->end_run(1);
  session.go_on(33.0);
  follow();
  EXPECT_EQ(state, State::idle) << "a stopped run's drive is nobody's";
  (void)session.estimator->begin_run(2);
  session.go_on(6.0);
  follow();
  EXPECT_EQ(state, State::measuring);
}

TEST_F(RunCycleTest, EverySampleIsAccountedForAcrossPipelines) {
  go_on(24.0);
  session.drive(kMoving);
  go_on(7.0);
  (void)session.estimator->begin_run(1);
  go_on(4.0);
  (void)session.estimator->end_run(2);
  go_on(24.0);
  session.drive(0.0);
  go_on(24.0);
  session.drive(kMoving);
  go_on(4.0);
  session.drive(0.0);
  go_on(15.0);
  session.finish();
  std::size_t in_stream = 0;
  for (const Record& record : session.sink.records) in_stream += record.kind == Kind::sample && record.channel == 0;
  const Tally tally = session.latest().channels[0].tally;
  EXPECT_EQ(tally.received, in_stream);
  EXPECT_EQ(tally.used + tally.rejected, in_stream);
  EXPECT_EQ(tally.queued, 0u);
  EXPECT_EQ(session.latest().channels[0].gaps, 0u);
}

TEST_F(RunCycleTest, RejectedSamplesAndGapsAreCountedOnceWhicheverPipelineSawThem) {
  for (int i = 1; i <= 9; ++i) {
    go_on(3.7);
    session.late_scan();
    session.spoil();
    go_on(0.5);
    if (i == 5) (void)session.estimator->begin_run(1);
    if (i == 7) (void)session.estimator->end_run(2);
    const ChannelView& table = session.latest().channels[0];
    EXPECT_EQ(table.tally.rejected, static_cast<std::uint64_t>(i));
    EXPECT_EQ(table.tally.late, static_cast<std::uint64_t>(i));
    EXPECT_EQ(table.gaps, static_cast<std::uint64_t>(i));
  }
  session.finish();
  EXPECT_EQ(session.latest().channels[0].tally.queued, 0u);
}

TEST_F(RunCycleTest, TheStreamIsInTheOrderOfTime) {
  session.go_on(24.0);
  session.drive(kMoving);
  session.go_on(3.0);
  (void)session.estimator->begin_run(1);
  session.go_on(3.0);
  session.finish();
  EXPECT_TRUE(std::is_sorted(session.sink.records.begin(), session.sink.records.end(),
                             [](const Record& a, const Record& b) { return a.t_ns < b.t_ns; }));
}

TEST_F(RunCycleTest, ResultsComeOnceASecondOfTheStreamWhileARunGoesOn) {
  session.go_on(24.0);
  session.drive(kMoving);
  session.go_on(10.0);
  session.finish();
  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 1u);
  const auto going_on = std::count_if(runs[0].results.begin(), runs[0].results.end(), [](auto& r) { return !r.final; });
  EXPECT_NEAR(static_cast<double>(going_on), 9.5, 1.0);
  EXPECT_EQ(going_on + 1, static_cast<std::ptrdiff_t>(session.sink.results.size())) << "none outside of a run";
}

TEST(RunCycle, WithoutBracketingTheSessionIsOneRunAndNobodyStartsOrStopsIt) {
  SimulatedSession session(one_mass_at_12_hz(), 10.0, 1e-6, 2, 1, false);
  session.go_on(15.0);
  EXPECT_TRUE(session.latest().run.on);
  EXPECT_FALSE(session.latest().run.bracketed);
  (void)session.estimator->begin_run(1);
  session.drive(kMoving);
  session.go_on(5.0);
  (void)session.estimator->end_run(2);
  session.drive(0.0);
  session.go_on(30.0);
  EXPECT_EQ(session.latest().run.number, 1u);
  session.finish();
  const auto runs = session.sink.runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].begins, 1u);
  EXPECT_EQ(runs[0].records.size(), session.sink.records.size());
  EXPECT_EQ(std::count_if(runs[0].records.begin(), runs[0].records.end(), [](auto& r) { return r.kind == Kind::run; }),
            3);
}

TEST(RunCycle, TheSpanIsLongEnoughForTheSlowestDrive) {
  Rig rig;
  rig.excitation.search_low_hz = 9.8;
  EXPECT_EQ(RunCycle::span_ns(rig), 10 * kSecond_ns);
  rig.excitation.search_low_hz = 0.1;
  EXPECT_EQ(RunCycle::span_ns(rig), 80 * kSecond_ns);
}

}  // namespace
}  // namespace dwell
