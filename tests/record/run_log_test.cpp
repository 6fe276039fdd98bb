#include "daemon/record/run_log.hpp"

#include "tests/record/logged_runs.hpp"

namespace dwell::record {
namespace {

struct RunLogTest : LoggedRuns {};

StoredEvent event_of(const std::string& text) {
  StoredEvent event;
  event.what = "state";
  event.text = text;
  return event;
}

TEST_F(RunLogTest, AResultThatNoReaderTakesIsAnEventInstead) {
  stream.armed();
  stream.play(1.0);
  stream.begins();
  more = ",\"x\":\"" + std::string(kMaxJson, 'x') + "\"";
  log.result(20, false, {});
  more.clear();
  log.result(21, true, {});
  stream.play(1.5);
  stream.ends();
  stream.play(1.1);
  const MemoryRun& run = store.runs.at(0);
  EXPECT_TRUE(run.closed);
  for (const NewEntry& entry : run.entries) EXPECT_TRUE(entry.kind == "stream" || entry.body.size() <= kMaxJson);
  EXPECT_EQ(std::count_if(run.entries.begin(), run.entries.end(), [](const NewEntry& e) { return e.kind == "result"; }),
            1);
  const auto events = events_of(run);
  const auto left_out =
      std::find_if(events.begin(), events.end(), [](const StoredEvent& e) { return e.what == "recording"; });
  ASSERT_NE(left_out, events.end());
  EXPECT_EQ(left_out->position, 20u);
  EXPECT_NE(left_out->text.find("is not recorded"), std::string::npos) << left_out->text;
  EXPECT_TRUE(told("is not recorded"));
}

TEST_F(RunLogTest, WhatIsPublishedOfTheModelStandsAtItsPosition) {
  stream.armed();
  log.model(3, {});  // of no run
  stream.play(1.0);
  stream.begins();
  log.model(20, {});
  stream.play(1.5);
  stream.ends();
  stream.play(1.1);
  const MemoryRun& run = store.runs.at(0);
  std::vector<StoredModel> models;
  for (const NewEntry& entry : run.entries)
    if (entry.kind == "estimate") models.push_back(*parse_model(entry.kind, entry.body));
  ASSERT_EQ(models.size(), 1u);
  EXPECT_EQ(models[0].position, 20u);
  EXPECT_EQ(models[0].utc.rfind("20", 0), 0u) << models[0].utc;
  EXPECT_EQ(models[0].from, R"({"last":19})");
  EXPECT_EQ(models[0].result, R"({"motion":null})");
}

TEST_F(RunLogTest, ARunHoldsTheStreamFromTheBirthOfItsPipelineToItsEnd) {
  stream.play(0.3);
  stream.armed();
  stream.play(10.0);
  const std::size_t elder = handed.size();
  stream.armed();
  stream.play(10.0);
  stream.armed();
  stream.play(5.0);
  stream.begins();
  stream.play(3.2);
  stream.ends();
  const std::size_t end = handed.size();
  stream.play(1.1);
  ASSERT_EQ(store.runs.size(), 1u);
  const MemoryRun& run = store.runs[0];
  EXPECT_TRUE(run.closed);
  EXPECT_EQ(run.header.begun_by, "drive");
  expect_stream(run, elder, end - elder);
  EXPECT_EQ(end_of(run).why, "drive stopped");
  EXPECT_EQ(end_of(run).records, end - elder);
  EXPECT_EQ(run.header.start_utc, iso_utc(kUtc_ns + handed[elder].t_ns));
}

TEST_F(RunLogTest, WhatIsNotWrittenIsNeverOlderThanASecond) {
  stream.starts();
  for (int i = 0; i < 500; ++i) {
    stream.play(0.013);
    const std::int64_t written_ns = store.runs[0].entries.back().t_ns;
    ASSERT_LE(stream.t_ns() - written_ns, BlockCutter::kBlock_ns + 20'000'000);
  }
  EXPECT_LE(store.commits, 7) << "6.5 s of stream";
}

TEST_F(RunLogTest, NothingOlderThanTheElderPipelineIsKept) {
  for (int i = 0; i < 20; ++i) {
    stream.armed();
    stream.play(10.0);
  }
  const std::size_t kept = log.kept_bytes();
  for (int i = 0; i < 20; ++i) {
    stream.armed();
    stream.play(10.0);
  }
  EXPECT_GT(kept, 0u);
  EXPECT_NEAR(static_cast<double>(log.kept_bytes()), static_cast<double>(kept), 0.1 * static_cast<double>(kept));
}

TEST_F(RunLogTest, ResultsAndEventsFollowTheBlockOfTheirPositionAndFinalsComeAfterTheEnd) {
  stream.armed();
  stream.play(0.5);
  log.event(event_of("before the run"));
  stream.begins();
  stream.play(0.7);
  const std::uint64_t at = stream.position();
  log.result(at, false, {});
  log.event(event_of("in the run"));
  stream.ends();
  log.result(stream.position(), true, {});
  stream.play(2.0);
  ASSERT_EQ(store.runs.size(), 1u);
  const MemoryRun& run = store.runs[0];
  std::string kinds;
  for (const NewEntry& entry : run.entries) kinds += entry.kind[0];
  EXPECT_EQ(kinds, "sesrere") << "stream, event, stream, result, event, result, end";
  EXPECT_EQ(events_of(run)[0].text, "before the run");
  EXPECT_EQ(events_of(run)[1].position, at);
  EXPECT_EQ(parse_result(run.entries[3].body)->position, at);
  EXPECT_TRUE(parse_result(run.entries[5].body)->final);
  EXPECT_TRUE(std::is_sorted(run.entries.begin(), run.entries.end(),
                             [](const NewEntry& a, const NewEntry& b) { return a.t_ns < b.t_ns; }));
}

TEST_F(RunLogTest, ARequestGivesTheRunItsLabelAndItsPersonAndStandsInItAtItsPosition) {
  Request start{.number = 3, .label = "oil film", .event = {}};
  start.event.what = "action";
  start.event.text = "start";
  start.event.comment = "second try";
  start.event.person = Person{1000, "anna"};
  stream.armed();
  log.request(start);
  stream.begins(3);
  const std::uint64_t began = stream.position();
  stream.play(2.0);
  Request stop{.number = 4, .label = {}, .event = {}};
  stop.event.text = "stop";
  log.request(stop);
  stream.ends(EndOfRun::by_operator, 4);
  log.finish();
  const MemoryRun& run = store.runs[0];
  EXPECT_EQ(run.header.begun_by, "operator");
  EXPECT_EQ(run.header.label, "oil film");
  EXPECT_EQ(run.header.comment, "second try");
  EXPECT_EQ(run.header.person->name, "anna");
  ASSERT_EQ(events_of(run).size(), 2u);
  EXPECT_EQ(events_of(run)[0].position, began);
  EXPECT_EQ(events_of(run)[1].text, "stop");
  EXPECT_EQ(end_of(run).why, "operator");
}

Request label_request(const std::string& label) {
  Request request{.number = 0, .label = label, .event = {}};
  request.event.what = "action";
  request.event.text = "run labelled \"" + label + "\"";
  request.event.person = Person{1000, "anna"};
  return request;
}

TEST_F(RunLogTest, ARunThatGoesOnIsLabelledWithAnEventAndItsEndHasTheLastLabel) {
  stream.starts();
  stream.play(2.0);
  log.request(label_request("oil film"));
  EXPECT_EQ(log.progress()->label, "oil film");
  const std::uint64_t at = stream.position();
  log.request(label_request("dry"));
  stream.play(2.0);
  stream.ends();
  stream.play(1.5);
  const MemoryRun& run = store.runs[0];
  const auto events = events_of(run);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].what, "label");
  EXPECT_EQ(events[0].after, "oil film");
  EXPECT_EQ(events[1].before, "oil film");
  EXPECT_EQ(events[1].after, "dry");
  EXPECT_EQ(events[1].position, at);
  EXPECT_EQ(events[1].person->name, "anna");
  EXPECT_EQ(end_of(run).label, "dry");
  EXPECT_TRUE(told(" \"dry\" ended: "));
}

// The recorder reads the stream later than orders: the label met the run before.
TEST_F(RunLogTest, ALabelWaitsForTheRecordOfTheRequestBeforeItAndForItsRun) {
  stream.starts();
  stream.play(2.0);
  Request start{.number = 7, .label = "b", .event = {}};
  log.request(start);
  Request label = label_request("c");
  label.after = 7;
  log.request(label);
  EXPECT_EQ(log.progress()->label, store.runs[0].header.label) << "the run before";
  stream.ends();
  stream.armed();
  stream.begins(7);
  EXPECT_EQ(log.progress()->label, "c");
  stream.play(2.0);
  stream.ends();
  stream.play(1.5);
  EXPECT_EQ(end_of(store.runs[0]).label, "");
  EXPECT_EQ(store.runs[1].header.label, "b");
  EXPECT_EQ(end_of(store.runs[1]).label, "c");
}

TEST_F(RunLogTest, ALabelThatFindsNoRunIsInNoneAndTheLogSaysSo) {
  stream.starts();
  stream.play(2.0);
  stream.ends();
  log.request(label_request("oil film"));
  stream.play(4.0);
  EXPECT_FALSE(told("no run has it")) << "its run may begin";
  stream.play(4.0);
  EXPECT_TRUE(events_of(store.runs[0]).empty());
  EXPECT_EQ(end_of(store.runs[0]).label, "");
  EXPECT_TRUE(told("the label \"oil film\" came while no run was recorded: no run has it"));
}

TEST_F(RunLogTest, WhatTheStreamTellsOfLossesAndFaultsIsAnEventAtItsPosition) {
  stream.starts();
  stream.play(0.2);
  stream.put({.t_ns = stream.t_ns(), .channel = 1, .kind = Kind::channel_state, .flags = 2});
  const std::uint64_t at = stream.position();
  const std::string then = iso_utc(kUtc_ns + stream.t_ns());
  for (int i = 0; i < 3; ++i)
    stream.put({.t_ns = stream.t_ns(), .value = 10.0, .channel = 1, .kind = Kind::loss, .flags = 2});
  stream.put({.t_ns = stream.t_ns(), .value = 4.0, .channel = 0, .kind = Kind::fault, .flags = 2});
  stream.put({.t_ns = stream.t_ns(), .channel = 1, .kind = Kind::channel_state, .flags = 0});
  stream.play(2.0);
  const auto events = events_of(store.runs[0]);
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[0].text, "channel y1 does not deliver: timeout");
  EXPECT_EQ(events[0].position, at);
  EXPECT_EQ(events[1].text, "channel y1: 30 samples lost, older than records already used");
  EXPECT_EQ(events[1].position, at + 1);
  EXPECT_EQ(events[2].text, "device amplifier: timeout, 4 times");
  EXPECT_EQ(events[3].text, "channel y1 delivers");
  for (const StoredEvent& event : events) EXPECT_EQ(event.utc, then) << event.text;
}

TEST_F(RunLogTest, AChangeOfStateStandsAtItsRecordWithTheInstantOfThat) {
  const auto change = [this](State before, State after) {
    Dwell dwell;
    dwell.state = after;
    const std::int64_t t_ns = stream.t_ns();
    log.state({t_ns, before}, dwell);
    return std::pair(stream.position(), iso_utc(kUtc_ns + t_ns));
  };
  stream.armed();
  stream.play(0.5);
  const auto early = change(State::idle, State::settling);
  stream.play(0.1);
  stream.begins();
  stream.play(0.3);
  const auto later = change(State::settling, State::measuring);
  stream.play(1.5);
  const auto events = events_of(store.runs.at(0));
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].what, "state");
  EXPECT_EQ(events[0].text, "idle -> settling");
  EXPECT_EQ(events[1].text, "settling -> measuring");
  EXPECT_EQ(std::pair(events[0].position, events[0].utc), early);
  EXPECT_EQ(std::pair(events[1].position, events[1].utc), later);
}

TEST_F(RunLogTest, ChannelStatesBeyondAThousandInABlockAreOneEventWithTheirNumber) {
  stream.starts();
  for (int i = 0; i < 1017; ++i)
    stream.put({.t_ns = stream.t_ns(), .channel = static_cast<std::uint16_t>(i % 2), .kind = Kind::channel_state});
  const std::uint64_t last = stream.position();
  stream.play(1.5);
  stream.ends();
  stream.play(1.1);
  const auto events = events_of(store.runs.at(0));
  ASSERT_EQ(events.size(), 1001u);
  EXPECT_EQ(events[999].text, "channel y1 delivers");
  EXPECT_EQ(events.back().what, "fault");
  EXPECT_EQ(events.back().text.rfind("17 more changes of channels' states ", 0), 0u) << events.back().text;
  EXPECT_EQ(events.back().position, last - 16) << "of the first that is not told by itself";
}

// Else the events of a run tell of fewer faults than its stream, by those of the 10 s before the drive.
TEST_F(RunLogTest, FaultsBeforeTheDriveThatAreInTheRunAreEventsOfItToo) {
  stream.armed();
  stream.play(1.0);
  stream.put(
      {.t_ns = stream.t_ns(), .value = 4.0, .kind = Kind::fault, .flags = static_cast<std::uint8_t>(Fault::timeout)});
  const std::uint64_t position = stream.position();
  stream.play(2.5);
  stream.begins();
  stream.play(2.0);
  const auto events = events_of(store.runs.at(0));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].what, "fault");
  EXPECT_NE(events[0].text.find("4 times"), std::string::npos) << events[0].text;
  EXPECT_LE(events[0].position, position + 1);
}

TEST_F(RunLogTest, AWallClockThatIsSetIsAnEvent) {
  stream.starts();
  stream.play(1.0);
  log.set_clock({stream.t_ns(), kUtc_ns + stream.t_ns() + 3'000'000'000});
  log.set_clock({stream.t_ns(), kUtc_ns + stream.t_ns()});
  stream.play(1.5);
  const auto events = events_of(store.runs[0]);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].what, "clock");
  EXPECT_EQ(events[0].text, "the wall clock was set by +3.000 s");
}

TEST_F(RunLogTest, TheLastBlockOfARunDoesNotWaitLongForARecordThatNeverComes) {
  stream.starts();
  stream.play(2.5);
  stream.ends();
  const auto turn = [this](std::int64_t t_ns) { log.set_clock({t_ns, kUtc_ns + t_ns}); };
  const auto written = [this] { return records_of(store.runs[0]).size(); };
  turn(stream.t_ns() + RunLog::kSilence_ns - 20'000'000);
  EXPECT_LT(written(), handed.size()) << "another run may begin at once";
  turn(stream.t_ns() + RunLog::kSilence_ns);
  EXPECT_EQ(written(), handed.size());
  stream.play(1.1);
  EXPECT_TRUE(store.runs[0].closed);
}

TEST_F(RunLogTest, WhatCameWhileItWasBehindIsInTheRunsFirstBatch) {
  behind = true;
  stream.starts();
  stream.play(0.5);
  EXPECT_TRUE(store.runs.empty());
  stream.play(1.0);
  ASSERT_EQ(store.runs.size(), 1U) << "with the first block that is complete";
  EXPECT_EQ(store.commits, 0);
  log.caught_up();
  stream.play(1.0);
  EXPECT_EQ(store.commits, 1);
  stream.ends();
  log.finish();
  expect_stream(store.runs[0], 0, handed.size());
}

TEST_F(RunLogTest, ARunThatCannotBeginWhileItIsBehindLeavesItsLabelsToTheNext) {
  behind = true;
  store.full = true;
  stream.starts();
  Request label;
  label.label = "warm";
  log.request(label);
  log.event({});
  stream.play(1.2);
  log.caught_up();
  EXPECT_EQ(log.progress(), nullptr);
  EXPECT_EQ(log.stopped(), "disk full");
  store.full = false;
  behind = false;
  stream.ends();
  stream.starts();
  stream.play(1.2);
  ASSERT_EQ(store.runs.size(), 1U);
  ASSERT_NE(log.progress(), nullptr);
  EXPECT_EQ(log.progress()->label, "warm");
  log.finish();
  EXPECT_EQ(events_of(store.runs[0]).size(), 1U) << "the label; what happened in the run that is not there is in none";
}

TEST_F(RunLogTest, TheEndOfTheServiceEndsTheRun) {
  stream.starts();
  stream.play(2.5);
  log.finish();
  EXPECT_EQ(end_of(store.runs[0]).why, "service stopped");
  expect_stream(store.runs[0], 0, handed.size());
}

}  // namespace
}  // namespace dwell::record
