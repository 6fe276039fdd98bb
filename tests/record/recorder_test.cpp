#include "daemon/record/recorder.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <optional>
#include <thread>

#include "daemon/clock.hpp"
#include "daemon/record/audit.hpp"
#include "daemon/record/directory_lock.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/record_ring.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/record/child.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"
#include "tests/record/synthetic_stream.hpp"

namespace dwell::record {
namespace {

// Waits for what another thread does; false: not within 20 s.
template <class Condition>
bool eventually(const Condition& condition) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < until) {
    if (condition()) return true;
    std::this_thread::yield();
  }
  return false;
}

struct RecorderTest : testing::Test {
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> paths;
    for (const auto& entry : std::filesystem::directory_iterator(scratch.path()))
      if (run_of_file_name(entry.path().filename().string()) > 0) paths.push_back(entry.path().string());
    std::sort(paths.begin(), paths.end());
    return paths;
  }
  // Hands to the recorder and keeps.
  [[nodiscard]] SyntheticStream stream_to(Recorder& recorder) {
    return {2, 500.0, [&](const Record& record) {
              handed.push_back(record);
              recorder.record(record);
            }};
  }

  Scratch scratch;
  Notices notices;
  std::vector<Record> handed;
};

TEST_F(RecorderTest, WhatItIsHandedStandsInTheFileBitForBit) {
  {
    Recorder recorder(recorder_options(scratch.path(), notices));
    SyntheticStream stream = stream_to(recorder);
    stream.armed();
    stream.play(1.0);
    Request start{.number = 1, .label = "first", .event = {}};
    start.event.what = "action";
    start.event.person = Person{1000, "anna"};
    recorder.request(start);
    stream.begins(1);
    stream.play(3.0);
    recorder.result(stream.position(), false, std::make_shared<const Dwell>());
    stream.play(1.0);
    stream.ends(EndOfRun::service_stops);
    recorder.result(stream.position(), true, std::make_shared<const Dwell>());
  }
  ASSERT_EQ(files().size(), 1u) << notices.text();
  auto reader = RunReader::open(files()[0]);
  ASSERT_TRUE(reader) << reader.error();
  EXPECT_EQ(reader->header().label, "first");
  EXPECT_EQ(reader->header().begun_by, "operator");
  std::size_t place = 0;
  ASSERT_TRUE(reader->stream([&](const Record& record) {
    EXPECT_EQ(std::memcmp(&record, &handed[place], sizeof record), 0) << place;
    return ++place < handed.size();
  }));
  EXPECT_EQ(place, handed.size());
  std::vector<std::uint64_t> positions;
  ASSERT_TRUE(reader->results(false, [&](const StoredResult& result) {
    positions.push_back(result.position);
    return true;
  }));
  ASSERT_EQ(positions.size(), 2u);
  EXPECT_EQ(positions[1], handed.size());
  ASSERT_TRUE(reader->end());
  EXPECT_EQ(reader->end()->why, "service stopped");
  EXPECT_EQ(reader->end()->records, handed.size());
  const auto audit = audit_run(files()[0], {});
  ASSERT_TRUE(audit);
  EXPECT_EQ(audit->state, AuditState::intact) << audit->where;
  EXPECT_TRUE(notices.hold("recording run 1 \"first\", begun by operator"));
  EXPECT_TRUE(notices.hold("anchor: "));
}

TEST_F(RecorderTest, TellsWhatItRecordsAndListsItsRuns) {
  Recorder recorder(recorder_options(scratch.path(), notices));
  SyntheticStream stream = stream_to(recorder);
  ASSERT_TRUE(eventually([&] { return recorder.state(raw_now_ns()).why_not == "no run goes on"; }));
  stream.starts();
  stream.play(2.5);
  ASSERT_TRUE(eventually([&] { return recorder.state(raw_now_ns()).run.samples >= 1500; }));
  const RecorderState state = recorder.state(raw_now_ns());
  EXPECT_TRUE(state.recording);
  EXPECT_EQ(state.run.run, 1);
  EXPECT_EQ(state.run.state, "recording");
  EXPECT_GT(state.run.bytes, 0u);
  EXPECT_EQ(state.lost_records, 0u);
  EXPECT_TRUE(state.alarms.empty());
  stream.ends();
  stream.play(1.5);
  ASSERT_TRUE(eventually([&] {
    const auto runs = recorder.runs();
    return runs->size() == 1 && runs->front().state == "closed";
  }));
  EXPECT_EQ(recorder.runs()->front().begun_by, "drive");
}

TEST_F(RecorderTest, TellsWhatCameOfAnOperatorsStart) {
  Recorder recorder(recorder_options(scratch.path(), notices));
  ASSERT_TRUE(recorder.await_first_file(std::chrono::seconds(20)));
  ASSERT_TRUE(std::filesystem::remove(scratch.path("next-1.new"))) << "the file of the first run";
  SyntheticStream stream = stream_to(recorder);
  stream.armed();
  stream.play(1.0);
  EXPECT_EQ(recorder.state(raw_now_ns()).newest_start, 0);
  recorder.request(Request{.number = 7, .label = "first", .event = {}});
  stream.begins(7);
  ASSERT_TRUE(eventually([&] { return recorder.state(raw_now_ns()).newest_start == 7; }));
  EXPECT_FALSE(recorder.state(raw_now_ns()).recording);
  EXPECT_NE(recorder.obstacle().why.find("the file was removed while it was written"), std::string::npos)
      << recorder.obstacle().why;
}

TEST_F(RecorderTest, TellsOfTheKeyThatItMakesAndOnlyThen) {
  for (const bool first : {true, false}) {
    Notices told;
    Recorder recorder(recorder_options(scratch.path(), told));
    ASSERT_TRUE(recorder.await_first_file(std::chrono::seconds(20)));
    EXPECT_EQ(told.hold("a key was made, for there was none: "), first);
  }
}

TEST_F(RecorderTest, ADirectoryThatCannotBeUsedIsAnAlarmAndNothingMore) {
  Recorder recorder(recorder_options("/proc/nowhere", notices));
  SyntheticStream stream = stream_to(recorder);
  stream.starts();
  stream.play(2.0);
  ASSERT_TRUE(eventually([&] { return recorder.state(raw_now_ns()).alarms.size() == 1; }));
  const RecorderState state = recorder.state(raw_now_ns());
  EXPECT_FALSE(state.recording);
  EXPECT_NE(state.why_not.find("/proc/nowhere"), std::string::npos) << state.why_not;
  EXPECT_TRUE(notices.hold("runs cannot be recorded: /proc/nowhere"));
}

TEST_F(RecorderTest, AFullDiskIsInTheWayOfEveryRunAndSaysHowMuchIsMissing) {
  RecorderOptions options = recorder_options(scratch.path(), notices);
  options.folder.room_bytes = 1'000'000'000'000'000;
  Recorder recorder(options);
  ASSERT_TRUE(eventually([&] { return !recorder.obstacle().why.empty(); }));
  EXPECT_TRUE(recorder.obstacle().of_every_run);
  const std::string why = recorder.obstacle().why;
  EXPECT_NE(why.find("a run needs 1000000002 MB to begin: free "), std::string::npos) << why;
  EXPECT_NE(why.find(" MB more there"), std::string::npos) << why;
  EXPECT_FALSE(std::filesystem::exists(scratch.path("reserve"))) << "what is missing is not taken by the reserve";
}

// The drive has begun a run that could not be recorded, and somebody mends what was in the way.
TEST_F(RecorderTest, WhatIsMendedIsNoObstacleAnyMoreAndTheLogWaitsForTheRun) {
  std::filesystem::create_directories(scratch.path("reserve/in the way"));
  Recorder recorder(recorder_options(scratch.path(), notices));
  ASSERT_TRUE(eventually([&] { return recorder.obstacle().of_every_run; }));
  SyntheticStream stream = stream_to(recorder);
  stream.starts();
  stream.play(2.0);
  ASSERT_TRUE(eventually([&] { return notices.hold("recording stops: "); }));
  EXPECT_EQ(recorder.state(raw_now_ns()).alarms.size(), 1u);
  std::filesystem::remove_all(scratch.path("reserve"));
  ASSERT_TRUE(eventually([&] { return !recorder.obstacle().of_every_run; })) << "an operator may start a run";
  EXPECT_EQ(recorder.obstacle().why, "what kept runs from being recorded is mended; a new run begins within 30 s");
  EXPECT_FALSE(recorder.take_restart());
  EXPECT_FALSE(notices.hold("runs can be recorded again")) << notices.text();
}

TEST_F(RecorderTest, WhereNoRunWaitsTheLogTellsAtOnceThatRunsCanBeRecorded) {
  std::filesystem::create_directories(scratch.path("reserve/in the way"));
  Recorder recorder(recorder_options(scratch.path(), notices));
  ASSERT_TRUE(eventually([&] { return recorder.obstacle().of_every_run; }));
  std::filesystem::remove_all(scratch.path("reserve"));
  EXPECT_TRUE(eventually([&] { return notices.hold("runs can be recorded again"); }));
}

// The service before was killed and is not gone yet when this one looks at the directory for the first time.
TEST_F(RecorderTest, ARunThatBeginsInADirectoryThatJustBecameFreeTellsOfTheOneThatWasCutOff) {
  ASSERT_EQ(in_child([&] {
              RunFolder folder(folder_options(scratch.path()));
              RunHeader header = rig_header();
              header.start_utc = "2026-11-23T00:00:00Z";
              if (const auto ready = folder.ready(); !ready) return std::string(ready.error());
              if (const auto begun = folder.begin(header, 1, {}); !begun) return std::string(begun.error());
              folder.settle();
              vanish();
              return std::string();
            }),
            "");
  std::optional<DirectoryLock> other(std::in_place);
  ASSERT_TRUE(other->take(scratch.path()));
  {
    Recorder recorder(recorder_options(scratch.path(), notices));
    ASSERT_TRUE(eventually([&] { return notices.hold("another dwelld records here"); }));
    other.reset();
    SyntheticStream stream = stream_to(recorder);
    stream.starts();
    stream.play(2.0);
    ASSERT_TRUE(eventually([&] { return notices.hold("recording run 2 \"rubber 3\", begun by service"); }))
        << notices.text();
    EXPECT_TRUE(notices.hold("run 1 was cut off")) << notices.text();
    EXPECT_TRUE(notices.hold("runs can be recorded again")) << notices.text();
    EXPECT_TRUE(eventually([&] { return recorder.state(raw_now_ns()).alarms.empty(); }));
  }
}

TEST_F(RecorderTest, AThreadThatDoesNotTurnIsAnAlarm) {
  Recorder recorder(recorder_options(scratch.path(), notices));
  const RecorderState state = recorder.state(raw_now_ns() + 7'000'000'000);
  ASSERT_FALSE(state.alarms.empty());
  EXPECT_EQ(state.alarms.back().text.substr(0, 33), "the disk has not answered for 7 s");
}

TEST_F(RecorderTest, RetentionDeletesWhatIsTooOldTellsTheLedgerAndSparesWhatIsKept) {
  for (int run = 0; run < 3; ++run) {
    Recorder recorder(recorder_options(scratch.path(), notices));
    SyntheticStream stream = stream_to(recorder);
    stream.starts();
    stream.play(1.5);
  }
  ASSERT_EQ(files().size(), 3u);
  const std::string kept = files()[1];
  std::ofstream(kept + std::string(kKeepSuffix)) << "";
  {
    RecorderOptions options = recorder_options(scratch.path(), notices);
    options.retention.days = 0.0;
    Recorder recorder(options);
    EXPECT_TRUE(eventually([&] { return files().size() == 1; }));
    EXPECT_TRUE(eventually([&] { return recorder.runs()->size() == 1; }));
    EXPECT_TRUE(eventually([&] { return notices.hold(" kB: older than 0 days"); }));
  }
  EXPECT_FALSE(notices.hold("deleted, 0 ")) << notices.text();
  EXPECT_EQ(files()[0], kept);
  const auto ledger = audit_ledger(scratch.path("ledger.dwell-ledger"), scratch.path(), {});
  ASSERT_TRUE(ledger) << ledger.error();
  EXPECT_TRUE(ledger->unbroken) << ledger->where;
  EXPECT_EQ(ledger->deleted.size(), 2u);
  EXPECT_TRUE(ledger->missing.empty());
}

TEST_F(RecorderTest, ARunsHeadArrivesWhereItIsAnchored) {
  RecorderOptions options = recorder_options(scratch.path(), notices);
  options.anchor.file = scratch.path("heads");
  {
    Recorder recorder(options);
    SyntheticStream stream = stream_to(recorder);
    stream.starts();
    stream.play(2.5);
    EXPECT_TRUE(eventually([&] { return std::filesystem::exists(scratch.path("heads")); }));
  }
  const auto anchors = read_anchors(scratch.path("heads"));
  ASSERT_TRUE(anchors) << anchors.error();
  AuditOptions audit_options;
  audit_options.anchors = {scratch.path("heads")};
  const auto audit = audit_run(files()[0], audit_options);
  ASSERT_TRUE(audit);
  EXPECT_EQ(audit->state, AuditState::intact) << audit->where;
}

// A recorder whose thread is held up as it begins to record, as by a disk that hangs.
class HeldRecorder {
 public:
  HeldRecorder(const std::string& directory, Notices& notices) {
    RecorderOptions options = recorder_options(directory, notices);
    options.tell = [this, tell = options.tell](const Notice& notice) {
      tell(notice);
      if (notice.text.rfind("recording run 1", 0) != 0) return;
      held_.set_value();
      released_.wait();
    };
    recorder_.emplace(options);
  }
  // Calls act() while the thread is held up. Call it once, after the run has started.
  template <class Act>
  void meanwhile(const Act& act) {
    held_.get_future().wait();
    act();
    goes_on_.set_value();
  }
  Recorder& operator*() { return *recorder_; }
  Recorder* operator->() { return &*recorder_; }

 private:
  std::promise<void> held_, goes_on_;
  std::future<void> released_ = goes_on_.get_future();
  std::optional<Recorder> recorder_;
};

[[nodiscard]] std::vector<std::string> event_texts(const std::string& file) {
  std::vector<std::string> texts;
  auto reader = RunReader::open(file);
  if (!reader || !reader->events([&](const StoredEvent& event) { return texts.push_back(event.text), true; }))
    ADD_FAILURE() << file;
  return texts;
}

TEST_F(RecorderTest, EventsThatFindNoRoomAreCountedInTheRunAndInTheLog) {
  {
    HeldRecorder recorder(scratch.path(), notices);
    SyntheticStream stream = stream_to(*recorder);
    stream.starts();
    recorder.meanwhile([&] {
      for (std::size_t i = 1; i <= Recorder::kInbox + 44; ++i) {
        StoredEvent event;
        event.what = "state";
        event.text = "change " + std::to_string(i);
        recorder->event(std::move(event));
      }
    });
    ASSERT_TRUE(eventually([&] { return recorder->state(raw_now_ns()).lost_events == 44; }));
    stream.play(1.5);
  }
  const std::string said = "44 events are lost: more than 256 waited for the recorder";
  EXPECT_TRUE(notices.hold(said)) << notices.text();
  const std::vector<std::string> texts = event_texts(files().at(0));
  ASSERT_EQ(texts.size(), Recorder::kInbox + 1);
  EXPECT_EQ(texts[Recorder::kInbox - 1], "change 256");
  EXPECT_EQ(texts.back(), said) << "where they are missing";
}

TEST_F(RecorderTest, ResultsThatFindNoRoomAreCountedInTheRunAndInTheLog) {
  {
    HeldRecorder recorder(scratch.path(), notices);
    SyntheticStream stream = stream_to(*recorder);
    stream.starts();
    recorder.meanwhile([&] {
      for (std::size_t i = 0; i < RecordRing::kResults + 7; ++i)
        recorder->result(stream.position(), false, std::make_shared<const Dwell>());
    });
    ASSERT_TRUE(eventually([&] { return recorder->state(raw_now_ns()).lost_results == 7; }));
    stream.play(1.5);
  }
  const std::string said = "7 results are lost: the recorder fell behind";
  EXPECT_TRUE(notices.hold(said)) << notices.text();
  const std::vector<std::string> texts = event_texts(files().at(0));
  ASSERT_EQ(texts.size(), 1U);
  EXPECT_EQ(texts.front(), said);
}

}  // namespace
}  // namespace dwell::record
