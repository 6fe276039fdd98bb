// What ends a recording amid a run, and how the next run goes on: a full disk, missing records, a crash.
#include "daemon/record/readiness.hpp"
#include "tests/record/logged_runs.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

struct InterruptedRecording : LoggedRuns {};

TEST_F(InterruptedRecording, AFullDiskEndsTheRunWithItsReasonAndTheNextRunSaysSo) {
  stream.starts();
  stream.play(5.0);
  store.full = true;
  const std::size_t before = handed.size();
  stream.play(1.5);
  ASSERT_TRUE(store.runs[0].closed) << "the reserve takes the last entries";
  EXPECT_EQ(end_of(store.runs[0]).why, "disk full");
  EXPECT_EQ(events_of(store.runs[0]).back().text, "recording stops: disk full");
  EXPECT_GE(records_of(store.runs[0]).size(), before - 500) << "no more than the block that was being gathered is lost";
  EXPECT_EQ(log.stopped(), "disk full");
  EXPECT_TRUE(told("recording stops: disk full"));
  stream.play(60.0);
  EXPECT_EQ(log.kept_bytes(), 0u) << "the stream of a run that is not recorded is not kept";
  store.full = false;
  log.goes_on();
  stream.ends(EndOfRun::by_operator);
  stream.starts();
  stream.play(2.0);
  ASSERT_EQ(store.runs.size(), 2u);
  EXPECT_EQ(log.stopped(), "");
  EXPECT_EQ(store.runs[1].header.begun_by, "service");
  EXPECT_EQ(events_of(store.runs[1])[0].text, "goes on after an interruption: run 1 ended: disk full");
}

struct NamedByAnOperator : InterruptedRecording {
  void begin() {
    Request request;
    request.number = 5;
    request.label = "mount A";
    request.event.comment = "new bearing";
    request.event.person = Person{1000, "anna"};
    log.request(request);
    stream.armed();
    stream.play(1.0);
    stream.begins(5);
    stream.play(3.0);
  }
  void go_on() {
    EXPECT_EQ(log.stopped(), "disk full");
    store.full = false;
    log.goes_on();
    stream.ends(EndOfRun::by_operator);
    stream.starts();
    stream.play(2.0);
    EXPECT_EQ(store.runs.back().header.begun_by, "service");
    EXPECT_EQ(store.runs.back().header.label, "mount A");
    EXPECT_EQ(store.runs.back().header.comment, "new bearing");
  }
};

TEST_F(NamedByAnOperator, ARunThatGoesOnKeepsItsLabelAndTheNextOneDoesNot) {
  begin();
  store.full = true;
  stream.play(1.5);
  go_on();
  stream.ends(EndOfRun::drive_stopped);
  stream.starts();
  stream.play(2.0);
  EXPECT_EQ(store.runs.back().header.label, "");
}

TEST_F(NamedByAnOperator, ARunThatCouldNotBeginKeepsItsLabelToo) {
  store.full = true;
  begin();
  go_on();
}

TEST_F(InterruptedRecording, ADiskThatIsFullAsTheRunBeginsIsToldAndTheRunIsNotRecorded) {
  store.full = true;
  stream.armed();
  stream.play(1.0);
  stream.begins();
  stream.play(5.0);
  EXPECT_TRUE(store.runs.empty());
  EXPECT_EQ(log.stopped(), "disk full");
}

TEST_F(InterruptedRecording, ADiskThatTakesNotEvenTheEndIsToldAsAnError) {
  stream.starts();
  stream.play(3.0);
  store.full = store.broken = true;
  stream.play(2.0);
  EXPECT_FALSE(store.runs[0].closed);
  EXPECT_TRUE(told("its end could not be recorded: input/output error"));
  EXPECT_EQ(log.stopped(), "disk full");
}

TEST_F(InterruptedRecording, WhereRecordsAreMissingTheRunEndsWithTheirCount) {
  stream.starts();
  stream.play(2.5);
  log.gap(1234);
  stream.play(10.0);
  ASSERT_TRUE(store.runs[0].closed);
  EXPECT_EQ(end_of(store.runs[0]).why, "recorder fell behind");
  EXPECT_EQ(events_of(store.runs[0]).back().text, "recorder fell behind: 1234 records of the stream are lost");
  EXPECT_EQ(store.runs.size(), 1u) << "not from the middle: its replay would be another";
  EXPECT_NE(log.stopped(), "");
}

TEST_F(InterruptedRecording, ARunNeverReachesBackOverAGap) {
  stream.armed();
  stream.play(3.0);
  log.gap(10);
  stream.play(3.0);
  stream.begins();
  stream.play(2.0);
  EXPECT_TRUE(store.runs.empty());
  EXPECT_EQ(log.stopped(), "the time before the run is not in memory");
}

TEST_F(InterruptedRecording, AfterACrashTheFirstRunGoesOnByTheServiceIfItComesSoon) {
  log.set_clock({stream.t_ns(), kUtc_ns});
  log.interrupted("run 7 was cut off");
  log.keep_label("rubber 3", "cold");
  log.goes_on();
  stream.armed();
  stream.play(12.0);
  stream.begins();
  stream.play(1.2);
  EXPECT_EQ(store.runs[0].header.begun_by, "service");
  EXPECT_EQ(store.runs[0].header.label, "rubber 3");
  EXPECT_EQ(store.runs[0].header.comment, "cold");
  EXPECT_EQ(events_of(store.runs[0])[0].text, "goes on after an interruption: run 7 was cut off");
}

TEST_F(InterruptedRecording, AfterACrashARunThatComesMuchLaterIsTheDrives) {
  log.set_clock({stream.t_ns(), kUtc_ns});
  log.interrupted("run 7 was cut off");
  log.keep_label("rubber 3", "cold");
  log.goes_on();
  stream.play(70.0);
  stream.starts();
  stream.play(1.2);
  EXPECT_EQ(store.runs[0].header.begun_by, "drive");
  EXPECT_EQ(store.runs[0].header.label, "") << "another run is not the operator's";
  EXPECT_EQ(events_of(store.runs[0]).size(), 1u);
}

// A second order would end the run that the first has just begun, and the second one would not have its label.
TEST_F(InterruptedRecording, ANewRunIsAskedForOnceWhileItIsOnItsWayThroughTheStream) {
  const Scratch scratch;
  Notices told_to;
  RunFolder folder(folder_options(scratch.path()));
  Readiness readiness(folder, log, told_to.tell());
  stream.starts();
  stream.play(5.0);
  store.full = true;
  stream.play(1.5);
  ASSERT_EQ(log.stopped(), "disk full");
  store.full = false;
  const auto asks_after = [&](double seconds) {
    const auto later_ns = static_cast<std::int64_t>(1e9 * seconds);
    return readiness.look({stream.t_ns() + later_ns, kUtc_ns + later_ns});
  };
  EXPECT_FALSE(asks_after(1.0));
  EXPECT_TRUE(asks_after(31.0)) << told_to.text();
  EXPECT_FALSE(asks_after(31.25));
  EXPECT_FALSE(asks_after(60.0));
  EXPECT_TRUE(asks_after(61.5)) << "the run that was asked for never came";
}

// The disk refused the last block after the run had ended: the reserve took it, and no recording stopped. The next run
// began as the continuation of one that had been complete.
TEST_F(InterruptedRecording, AFullDiskAfterTheEndOfARunStopsNothingAndTheRunKeepsItsReason) {
  stream.starts();
  stream.play(2.5);
  stream.ends();
  log.result(handed.size(), true, Dwell());
  store.full = true;
  stream.play(1.5);
  ASSERT_TRUE(store.runs[0].closed);
  EXPECT_EQ(end_of(store.runs[0]).why, "drive stopped");
  const auto results = [](const MemoryRun& run) {
    return std::count_if(run.entries.begin(), run.entries.end(),
                         [](const NewEntry& entry) { return entry.kind == "result"; });
  };
  EXPECT_EQ(results(store.runs[0]), 1);
  EXPECT_EQ(log.stopped(), "");
  EXPECT_FALSE(told("recording stops"));
  store.full = false;
  stream.starts();
  stream.play(1.5);
  ASSERT_EQ(store.runs.size(), 2u);
  EXPECT_EQ(store.runs[1].header.begun_by, "drive");
  EXPECT_EQ(results(store.runs[1]), 0) << "it is the other run's";
}

}  // namespace
}  // namespace dwell::record
