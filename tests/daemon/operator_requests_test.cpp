// What operators ask for: whether it can be done, and what the record is told of it.
#include "daemon/run/operator_requests.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <vector>

#include "tests/daemon/log_to_read.hpp"
#include "tests/daemon/one_mass_rig.hpp"

namespace dwell {
namespace {

using Verb = OperatorRequest::Verb;

struct OperatorRequestsTest : testing::Test {
  struct Sink final : record::RequestSink {
    void request(record::Request request) override { requests.push_back(std::move(request)); }
    [[nodiscard]] record::Obstacle obstacle() const override { return in_the_way; }
    std::vector<record::Request> requests;
    record::Obstacle in_the_way;
  };

  // Its threads do not run: what is asked for stays in the queue.
  void begin(bool recording) {
    config::RigFile file;
    file.recording.on = recording;
    file.rig = test::one_mass_rig();
    run.emplace(file, std::vector<DeviceFeed>{}, nullptr, log, [] {});
    operators.emplace(*run, log, &sink);
  }
  // The reason why not; empty: it is done.
  std::string ask(Verb verb, const std::string& label = {}, const std::string& comment = {}) {
    const auto done = operators->ask({verb, label, comment}, {1000, "anna"});
    return done ? "" : done.error();
  }

  test::LogToRead log{"operators"};
  Sink sink;
  std::optional<dwell::Run> run;
  std::optional<OperatorRequests> operators;
};

TEST_F(OperatorRequestsTest, TheRecordLearnsWhoAskedForWhatAndWhyBeforeTheStreamDoes) {
  begin(true);
  EXPECT_EQ(ask(Verb::start, "sweep 3", "new damper"), "");
  EXPECT_EQ(ask(Verb::rearm, "", "specimen touched"), "");
  EXPECT_EQ(ask(Verb::stop), "");
  ASSERT_EQ(sink.requests.size(), 3u);
  const record::Request &start = sink.requests[0], &rearm = sink.requests[1], &stop = sink.requests[2];
  EXPECT_EQ(start.number, 1);
  EXPECT_EQ(start.label, "sweep 3");
  EXPECT_EQ(start.event.what, "action");
  EXPECT_EQ(start.event.text, "run \"sweep 3\" started by anna (uid 1000)");
  EXPECT_EQ(start.event.person->uid, 1000u);
  EXPECT_EQ(start.event.before, "no run");
  EXPECT_EQ(start.event.after, "run \"sweep 3\", started by anna (uid 1000)");
  EXPECT_EQ(start.event.comment, "new damper");
  EXPECT_EQ(rearm.number, 2);
  EXPECT_EQ(rearm.event.before, "idle") << "what the re-arm ends";
  EXPECT_EQ(rearm.event.after, "a new dwell begins");
  EXPECT_EQ(rearm.event.comment, "specimen touched");
  EXPECT_EQ(stop.number, 3);
  EXPECT_EQ(stop.event.before, start.event.after);
  EXPECT_EQ(stop.event.after, "no run");
  EXPECT_EQ(log.lines(), (std::vector<std::string>{"info run \"sweep 3\" started by anna (uid 1000): new damper",
                                                   "info dwell re-armed by anna (uid 1000): specimen touched",
                                                   "info run stopped by anna (uid 1000)"}));
}

TEST_F(OperatorRequestsTest, AnOperatorsRunIsNotReplacedByAnother) {
  begin(true);
  EXPECT_EQ(ask(Verb::start, "a"), "");
  EXPECT_EQ(ask(Verb::start, "b"), "run \"a\", started by anna (uid 1000) goes on: stop it first, with dwellctl stop");
  EXPECT_EQ(ask(Verb::stop), "");
  EXPECT_EQ(ask(Verb::start, "b"), "");
  EXPECT_EQ(sink.requests.size(), 3u) << "what is refused is not told of";
}

TEST_F(OperatorRequestsTest, ARunThatGoesOnIsLabelledAndTheLabelHasNoPlaceInTheStream) {
  begin(true);
  EXPECT_EQ(ask(Verb::label, "oil film"), "nothing to label: no run goes on");
  EXPECT_EQ(ask(Verb::start, "a"), "");
  EXPECT_EQ(ask(Verb::label, "oil film", "as seen"), "");
  ASSERT_EQ(sink.requests.size(), 2u);
  const record::Request& label = sink.requests[1];
  EXPECT_EQ(label.number, 0);
  EXPECT_EQ(label.after, 1) << "the start before it";
  EXPECT_EQ(label.label, "oil film");
  EXPECT_EQ(label.event.text, "run labelled \"oil film\" by anna (uid 1000)");
  EXPECT_EQ(label.event.comment, "as seen");
  EXPECT_EQ(ask(Verb::start, "b"),
            "run \"oil film\", started by anna (uid 1000) goes on: stop it first, with dwellctl stop");
  sink.in_the_way.why = "disk full";
  EXPECT_EQ(ask(Verb::label, "dry"), "the run is not recorded: disk full");
  EXPECT_EQ(sink.requests.size(), 2u) << "what is refused is not told of";
  sink.in_the_way.why.clear();
  EXPECT_EQ(ask(Verb::stop), "");
  EXPECT_EQ(sink.requests.back().number, 2) << "numbers are of the stream";
}

TEST_F(OperatorRequestsTest, WhereTheDiskIsFullARunThatGoesOnIsNotBlamedForIt) {
  begin(true);
  EXPECT_EQ(ask(Verb::start, "a"), "");
  sink.in_the_way = {"disk full: 12 MB are free in /runs, a run needs 288 MB: free 276 MB more there", true};
  EXPECT_EQ(ask(Verb::start, "b"),
            "recording is stopped: disk full: 12 MB are free in /runs, a run needs 288 MB: free 276 MB more there; "
            "once that is mended, run \"a\", started by anna (uid 1000) goes on by itself within 30 s");
  sink.in_the_way = {"a new run begins within 30 s", false};
  EXPECT_EQ(ask(Verb::start, "b"),
            "run \"a\", started by anna (uid 1000) waits to go on by itself: a new run begins within 30 s");
  EXPECT_EQ(ask(Verb::stop), "");
  EXPECT_EQ(sink.requests.size(), 2u) << "what is refused is not told of";
}

TEST_F(OperatorRequestsTest, ARunThatCouldNotBeRecordedIsRefusedWithTheReason) {
  begin(true);
  sink.in_the_way = {"disk full: free 276 MB more", true};
  EXPECT_EQ(ask(Verb::start, "a"),
            "recording is stopped: disk full: free 276 MB more; once that is mended, start the run again");
  EXPECT_TRUE(sink.requests.empty());
  sink.in_the_way = {"recorder fell behind", false};
  EXPECT_EQ(ask(Verb::start, "a"), "") << "what ended the drive's run does not keep another from being recorded";
}

TEST_F(OperatorRequestsTest, WithoutARunThereIsNothingToStop) {
  begin(true);
  EXPECT_EQ(ask(Verb::stop), "nothing to stop: no run goes on");
  EXPECT_TRUE(sink.requests.empty());
}

TEST_F(OperatorRequestsTest, WithoutRecordingThereIsNothingToStartOrToStop) {
  begin(false);
  for (const Verb verb : {Verb::start, Verb::stop}) EXPECT_NE(ask(verb, "a").find("not recording"), std::string::npos);
  EXPECT_EQ(ask(Verb::rearm), "");
}

TEST_F(OperatorRequestsTest, MoreThanTheStreamTakesAtOnceIsRefusedAndNotToldOf) {
  begin(true);
  std::size_t done = 0;
  for (int i = 0; i < 100; ++i) done += ask(Verb::rearm).empty();
  EXPECT_GE(done, 1u);
  EXPECT_LE(done, 16u);
  EXPECT_EQ(sink.requests.size(), done);
  EXPECT_EQ(ask(Verb::rearm), "too many at once; try again");
}

TEST(UserName, IsWhatTheSystemKnows) {
  EXPECT_EQ(user_name(0), "root");
  EXPECT_EQ(user_name(4'000'000'000u), "");
}

}  // namespace
}  // namespace dwell
