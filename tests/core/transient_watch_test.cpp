#include "core/motion/transient_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/base/instants.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_recorder.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kDrive_hz = 4.0;
constexpr double kScans_hz = 200.0;

Dwell dwell_of(int index, double start_s, State state = State::settling) {
  Dwell dwell;
  dwell.index = index;
  dwell.state = state;
  dwell.start_s = start_s;
  return dwell;
}
Dwell settled_dwell(int index, double start_s, double settled_s) {
  Dwell dwell = dwell_of(index, start_s, State::measuring);
  dwell.settled_s = settled_s;
  return dwell;
}

// Scans of a table at rest until onset_s, then driven; what the service would say of it is up to the test.
struct WatchedStart {
  explicit WatchedStart(double onset_s = 1.0) : onset_ns(to_ns(onset_s)) {}

  // Scans until then. said: as it stands, asked ten times a second.
  void go_on(double until_s, const Dwell& said) {
    for (; to_s(scans * step_ns) < until_s; ++scans) {
      const std::int64_t t_ns = scans * step_ns;
      for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c) {
        double value = normal(rng);
        if (t_ns >= onset_ns) value += exact_reading(rig, motion.at(to_s(t_ns - onset_ns)), c);
        const Record record{.t_ns = t_ns, .value = value, .channel = static_cast<std::uint16_t>(c)};
        stream.push_back(record);
        watch.take(record, t_ns);
      }
      if (scans % 20 != 0) continue;
      watch.follow(said);
      if (watch.due() && hands_over) {
        jobs.push_back(watch.hand_over());
        out = true;
      }
    }
  }
  // A second of rest, then two of dwell 1: its first job is out.
  void begin_dwell() {
    go_on(1.0, Dwell());
    go_on(3.0, dwell_of(1, 1.0));
  }
  // The same dwell settles and ends after another second.
  TransientJob last_job() {
    begin_dwell();
    give_back();
    hands_over = false;
    go_on(4.0, settled_dwell(1, 1.0, 3.5));
    watch.ended(settled_dwell(1, 1.0, 3.5));
    EXPECT_TRUE(watch.due());
    return watch.hand_over();
  }
  // Gives back the newest job without having done it: its reason tells it from others.
  void give_back(const std::string& as = "not done", AnewSearch anew = AnewSearch::not_asked) {
    TransientJob job = jobs.back();
    job.result.estimate.reason = as;
    job.result.estimate.anew = anew;
    watch.take_back(std::move(job));
    out = false;
  }

  const std::int64_t step_ns = to_ns(1 / kScans_hz);
  std::int64_t onset_ns;
  Chain chain = free_chain();
  Rig rig = rig_of(chain, kDrive_hz);
  DrivenChain motion{chain, {kDrive_hz, 0.005, 0.0, 0.0}, DrivenChain::Start::rest};
  TransientWatch watch{rig};
  std::mt19937_64 rng{1};
  std::normal_distribution<double> normal{0.0, 1e-6};
  std::vector<Record> stream;
  std::vector<TransientJob> jobs;
  std::int64_t scans = 0;
  bool hands_over = true;
  bool out = false;  // the newest job has not been given back
};

using Phase = TransientWatch::Phase;

TEST(TransientWatch, AsksForNothingWhileTheRigIsIdle) {
  WatchedStart start(1e6);
  start.go_on(30.0, Dwell());
  EXPECT_TRUE(start.jobs.empty());
  EXPECT_EQ(start.watch.phase(), Phase::waiting);
}

TEST(TransientWatch, AsksTwoPeriodsAfterTheTableBeganToMove) {
  WatchedStart start;
  start.begin_dwell();
  ASSERT_EQ(start.jobs.size(), 1u) << "one at a time";
  const TransientEstimate& asked = start.jobs[0].result;
  EXPECT_NEAR(asked.from_s, 1.0 - 1.5 / kDrive_hz, 0.01) << "with what it was at rest before";
  EXPECT_NEAR(asked.until_s, 1.0 + 2 / kDrive_hz, 0.11);
  EXPECT_EQ(asked.given, start.jobs[0].readings.size());
}

TEST(TransientWatch, DoesTheLastEstimatesWorkThreeTimesInAll) {
  WatchedStart start;
  for (double t = 1.0; t < 60.0; t += 0.1) {
    start.go_on(t, dwell_of(1, 1.0));
    if (start.out) start.give_back();
  }
  ASSERT_GT(start.jobs.size(), 8u);
  double all = 0.0;
  for (std::size_t i = 0; i < start.jobs.size(); ++i) {
    const auto given = static_cast<double>(start.jobs[i].result.given);
    all += given;
    if (i > 0) {
      EXPECT_GE(given, 1.5 * static_cast<double>(start.jobs[i - 1].result.given));
    }
  }
  EXPECT_LT(all, 3.0 * static_cast<double>(start.jobs.back().result.given));
}

// The search may take minutes: what the first readings say must not wait for it.
TEST(TransientWatch, LeavesTheLongSearchToTheSecondEstimateOfAContradictedStretch) {
  WatchedStart start;
  start.begin_dwell();
  ASSERT_EQ(start.jobs.size(), 1u);
  EXPECT_FALSE(start.jobs[0].result.may_search);
  start.give_back("contradicted", AnewSearch::put_off);
  start.go_on(3.3, dwell_of(1, 1.0));
  ASSERT_EQ(start.jobs.size(), 2u) << "as soon as after any other estimate";
  EXPECT_TRUE(start.jobs[1].result.may_search);
  const std::size_t searched = start.jobs[1].readings.size();
  start.give_back("contradicted", AnewSearch::done);
  start.go_on(60.0, dwell_of(1, 1.0));
  ASSERT_EQ(start.jobs.size(), 3u);
  EXPECT_GE(start.jobs[2].readings.size(), 4 * searched);
}

TEST(TransientWatch, StopsAJobWhoseStretchIsOver) {
  WatchedStart start;
  start.begin_dwell();
  ASSERT_EQ(start.jobs.size(), 1u);
  EXPECT_FALSE(start.jobs[0].stop.stop_requested());
  start.go_on(3.2, Dwell());
  EXPECT_TRUE(start.jobs[0].stop.stop_requested());
}

TEST(TransientWatch, StopsAJobOfTheDriveBefore) {
  WatchedStart start;
  start.go_on(1.0, Dwell());
  start.go_on(6.0, dwell_of(1, 1.0));
  ASSERT_EQ(start.jobs.size(), 1u);
  EXPECT_FALSE(start.jobs[0].stop.stop_requested());
  start.watch.follow(dwell_of(1, 6.0));  // after a hold of twenty periods
  EXPECT_TRUE(start.jobs[0].stop.stop_requested());
}

TEST(TransientWatch, NeverStopsTheLastEstimateOfADwell) {
  WatchedStart start;
  const TransientJob last = start.last_job();
  start.go_on(8.0, dwell_of(2, 4.5));
  start.go_on(9.0, Dwell());
  EXPECT_FALSE(last.stop.stop_requested());
}

TEST(TransientWatch, MakesTheSearchThatWasPutOffEvenWhenTheDwellHasSettledMeanwhile) {
  WatchedStart start;
  start.begin_dwell();
  start.give_back("contradicted", AnewSearch::put_off);
  start.go_on(3.2, settled_dwell(1, 1.0, 3.1));
  ASSERT_EQ(start.jobs.size(), 2u);
  EXPECT_TRUE(start.jobs[1].result.may_search);
  start.give_back("contradicted", AnewSearch::done);
  start.go_on(60.0, settled_dwell(1, 1.0, 3.1));
  EXPECT_EQ(start.jobs.size(), 2u) << "once";
}

TEST(TransientWatch, MakesTheSearchAtOnceWhereNoMoreReadingsCanCome) {
  WatchedStart start;
  start.hands_over = false;
  start.go_on(1.0, Dwell());
  start.go_on(500'000.0 / 7 / 3 / kScans_hz + 20.0, dwell_of(1, 1.0));
  ASSERT_TRUE(start.watch.due());
  EXPECT_TRUE(start.watch.hand_over().result.may_search);
}

TEST(TransientWatch, StopsItsLastJobWhenItGoesItself) {
  TransientJob last;
  {
    WatchedStart start;
    last = start.last_job();
    EXPECT_FALSE(last.stop.stop_requested());
  }
  EXPECT_TRUE(last.stop.stop_requested());
}

TEST(TransientWatch, BeginsAnotherStretchWithoutTheLongSearch) {
  WatchedStart start;
  start.begin_dwell();
  start.give_back("contradicted", AnewSearch::put_off);
  start.go_on(3.1, Dwell());
  start.go_on(6.0, dwell_of(2, 3.2));
  ASSERT_EQ(start.jobs.size(), 2u);
  EXPECT_FALSE(start.jobs[1].result.may_search);
}

TEST(TransientWatch, HandsOverNoMoreThanAnEstimateTakesAndThenRests) {
  WatchedStart start;
  const double most_s = 500'000.0 / 7 / 3 / kScans_hz;  // seven states or a few more, three channels
  for (double t = 1.0; t < most_s + 20.0; t += 1.0) {
    start.go_on(t, dwell_of(1, 1.0));
    if (start.out) start.give_back();
  }
  const std::size_t given = start.jobs.back().result.given, jobs = start.jobs.size();
  EXPECT_LE(given, 500'000u / 7);
  EXPECT_GT(given, 500'000u / 14);
  start.go_on(most_s + 60.0, dwell_of(1, 1.0));
  EXPECT_EQ(start.jobs.size(), jobs);
}

// A drive so slow that no two periods find room: what there is, is estimated.
TEST(TransientWatch, AsksOnceItIsFullWhereTwoPeriodsDoNotFit) {
  WatchedStart start;
  start.rig.excitation.frequency_hz = 0.005;
  start.watch = TransientWatch(start.rig);
  start.go_on(100.0, Dwell());
  start.go_on(300.0, dwell_of(1, 99.0));
  ASSERT_EQ(start.jobs.size(), 1u);
  EXPECT_LT(start.jobs[0].result.until_s, 300.0);
  EXPECT_GT(start.jobs[0].result.until_s, 130.0) << "half of it after the beginning";
}

TEST(TransientWatch, AsksForNothingWhileTheDwellIsMeasuredAndKeepsTheNewestEstimateToCompare) {
  WatchedStart start;
  start.go_on(3.0, dwell_of(1, 1.0));
  start.go_on(4.0, settled_dwell(1, 1.0, 3.5));
  start.give_back("came late");
  ASSERT_TRUE(start.watch.newest());
  EXPECT_EQ(start.watch.newest()->estimate.reason, "came late") << "its readings are this dwell's";
  start.go_on(30.0, settled_dwell(1, 1.0, 3.5));
  EXPECT_EQ(start.jobs.size(), 1u);
  EXPECT_TRUE(start.watch.newest());
}

TEST(TransientWatch, GoesOnWhereTheVerdictIsTakenBack) {
  WatchedStart start;
  start.go_on(3.0, dwell_of(1, 1.0));
  start.give_back();
  start.go_on(4.0, settled_dwell(1, 1.0, 3.5));
  start.go_on(6.0, dwell_of(1, 1.0));
  ASSERT_EQ(start.jobs.size(), 2u);
  EXPECT_EQ(start.jobs[1].result.from_s, start.jobs[0].result.from_s);
  EXPECT_GE(start.jobs[1].result.until_s, 4.0);
}

// The search for what is missing costs ten times as much as an estimate.
TEST(TransientWatch, EstimatesSeldomOnceItHasSearched) {
  WatchedStart start;
  start.go_on(1.0, Dwell());
  start.go_on(2.0, dwell_of(1, 1.0));
  ASSERT_EQ(start.jobs.size(), 1u);
  start.give_back("contradicted", AnewSearch::done);
  start.go_on(3.0, dwell_of(1, 1.0));  // more than twice as many readings
  EXPECT_EQ(start.jobs.size(), 1u);
  start.go_on(6.0, dwell_of(1, 1.0));
  EXPECT_EQ(start.jobs.size(), 2u);
}

TEST(TransientWatch, GivesADwellThatHasEndedALastEstimateFromAllOfItsStretch) {
  for (const bool told_late : {false, true}) {
    WatchedStart start;
    start.begin_dwell();
    start.give_back();
    start.hands_over = false;
    const Dwell settled = settled_dwell(1, 1.0, 3.5);
    start.go_on(20.0, settled);
    if (told_late) start.go_on(21.0, dwell_of(2, 20.0));  // the next dwell is on before the end of this one is told
    start.watch.ended(settled);
    ASSERT_TRUE(start.watch.due());
    TransientJob last = start.watch.hand_over();
    ASSERT_TRUE(last.ended);
    EXPECT_EQ(last.ended->index, 1);
    EXPECT_NEAR(last.result.from_s, 1.0 - 1.5 / kDrive_hz, 0.01);
    EXPECT_NEAR(last.result.until_s, 20.0, 0.11) << "told late: " << told_late;
    last.result.estimate.reason = "of the dwell that has ended";
    const auto handed_on = start.watch.take_back(std::move(last));
    ASSERT_TRUE(handed_on);
    EXPECT_EQ(handed_on->estimate.reason, "of the dwell that has ended");
    EXPECT_FALSE(start.watch.newest()) << "it is no estimate of the dwell that is on";
  }
}

TEST(TransientWatch, GivesADwellThatNeverSettledNoLastEstimate) {
  WatchedStart start;
  start.go_on(3.0, dwell_of(1, 1.0));
  start.give_back();
  start.watch.ended(dwell_of(1, 1.0));
  EXPECT_FALSE(start.watch.due());
}

// A dwell may turn out to have settled only when it has ended.
TEST(TransientWatch, GivesADwellThatIsKnownToHaveSettledOnlyAtItsEndALastEstimate) {
  WatchedStart start;
  start.begin_dwell();
  start.give_back();
  start.go_on(4.0, Dwell());
  start.watch.ended(settled_dwell(1, 1.0, 2.0));
  ASSERT_TRUE(start.watch.due());
  EXPECT_NEAR(start.watch.hand_over().result.until_s, 3.0, 0.11);
}

TEST(TransientWatch, TakesNoMoreReadingsOfASettledDwellThanItsLastEstimateTakes) {
  WatchedStart start;
  start.begin_dwell();
  start.give_back();
  start.hands_over = false;
  start.go_on(200.0, settled_dwell(1, 1.0, 2.0));
  EXPECT_EQ(start.watch.phase(), Phase::complete);
  start.watch.ended(settled_dwell(1, 1.0, 2.0));
  ASSERT_TRUE(start.watch.due());
  const TransientJob last = start.watch.hand_over();
  EXPECT_EQ(last.result.given, 500'000u / 7 / 5) << "a fifth of the readings that an estimate may take";
  EXPECT_EQ(last.readings.size(), last.result.given) << "what it names is what it uses";
}

TEST(TransientWatch, GivesADwellWhoseTransientIsLongerThanThatNoLastEstimate) {
  WatchedStart start;
  start.go_on(1.0, Dwell());
  start.hands_over = false;
  start.go_on(60.0, dwell_of(1, 1.0));
  start.go_on(70.0, settled_dwell(1, 1.0, 59.0));
  start.watch.ended(settled_dwell(1, 1.0, 59.0));
  EXPECT_FALSE(start.watch.due());
}

TEST(TransientWatch, HandsOnWhichReadingsAreAtFault) {
  WatchedStart start;
  start.go_on(2.0, dwell_of(1, 1.0));
  start.watch.follow(dwell_of(1, 1.0), {{1, "y1: clipped: 12 %"}});
  start.give_back();
  start.hands_over = false;
  start.go_on(4.0, dwell_of(1, 1.0));
  start.watch.follow(dwell_of(1, 1.0), {{1, "y1: clipped: 12 %"}});
  ASSERT_TRUE(start.watch.due());
  const TransientJob job = start.watch.hand_over();
  ASSERT_EQ(job.result.at_fault.size(), 1u);
  EXPECT_EQ(job.result.at_fault[0].what, "y1: clipped: 12 %");
}

TEST(TransientWatch, BeginsANewStretchWithANewHoldAndDropsWhatComesOfTheOldOne) {
  WatchedStart start;
  start.go_on(3.0, dwell_of(1, 1.0));
  start.go_on(5.5, dwell_of(1, 1.0));
  start.go_on(8.0, dwell_of(1, 5.0));  // the drive has left its hold: the same dwell, begun anew
  EXPECT_EQ(start.jobs.size(), 1u) << "the job of the old stretch is still out";
  start.give_back();
  EXPECT_FALSE(start.watch.newest());
  start.go_on(8.2, dwell_of(1, 5.0));
  ASSERT_EQ(start.jobs.size(), 2u);
  EXPECT_NEAR(start.jobs[1].result.from_s, 5.0 - 1.5 / kDrive_hz, 0.01);
}

TEST(TransientWatch, GoesOnWithItsStretchWhileTheDriveIsRampedUp) {
  WatchedStart start;
  start.hands_over = false;
  start.go_on(1.0, Dwell());
  for (double t = 1.2; t < 4.0; t += 0.2) start.go_on(t, dwell_of(1, t - 0.2));  // out of one hold after another
  start.hands_over = true;
  start.go_on(4.2, dwell_of(1, 4.0));
  ASSERT_EQ(start.jobs.size(), 1u);
  EXPECT_NEAR(start.jobs[0].result.from_s, 1.0 - 1.5 / kDrive_hz, 0.01);
}

TEST(TransientWatch, KeepsAnEstimateForTheDwellAndNoOther) {
  WatchedStart start;
  start.go_on(3.0, dwell_of(1, 1.0));
  start.give_back();
  start.hands_over = false;
  start.go_on(5.0, dwell_of(1, 4.0));
  EXPECT_TRUE(start.watch.newest()) << "a new hold of the same dwell";
  start.go_on(6.0, dwell_of(2, 5.0));
  EXPECT_FALSE(start.watch.newest());
  start.hands_over = true;
  start.go_on(7.0, dwell_of(2, 5.0));
  start.give_back();
  EXPECT_TRUE(start.watch.newest());
  start.go_on(8.0, Dwell());
  EXPECT_FALSE(start.watch.newest()) << "idle";
  EXPECT_EQ(start.watch.phase(), Phase::waiting);
}

// Whoever has a recording of just these readings can make the estimate again.
TEST(TransientWatch, GivesWhatARecordingOfTheSameStretchGives) {
  WatchedStart start;
  start.go_on(3.0, dwell_of(1, 1.0));
  ASSERT_EQ(start.jobs.size(), 1u);
  start.jobs[0].run(start.rig);
  start.watch.take_back(std::move(start.jobs[0]));
  const TransientEstimate& live = *start.watch.newest();
  MotionRecorder recorder(start.rig);
  for (const Record& record : start.stream)
    if (to_s(record.t_ns) >= live.from_s && to_s(record.t_ns) <= live.until_s) recorder.take(record);
  EXPECT_EQ(recorder.size(), live.given);
  const MotionEstimate again = estimate_motion(start.rig, recorder.data());
  ASSERT_EQ(live.estimate.reason, "");
  ASSERT_EQ(again.elements.size(), live.estimate.elements.size());
  EXPECT_EQ(again.start_s, live.estimate.start_s);
  EXPECT_EQ(again.end_s, live.estimate.end_s);
  for (std::size_t e = 0; e < again.elements.size(); ++e) {
    EXPECT_EQ(again.elements[e].stiffness.value, live.estimate.elements[e].stiffness.value);
    EXPECT_EQ(again.elements[e].damping.u, live.estimate.elements[e].damping.u);
  }
}

}  // namespace
}  // namespace dwell
