// dwellctl watch without a terminal, as its users see it: what is appended, when it ends, and its exit code.
#include <gtest/gtest.h>
#include <unistd.h>

#include <memory>

#include "daemon/report/motion_report.hpp"
#include "tests/ctl/program.hpp"
#include "tests/ctl/sample_text.hpp"
#include "tests/ctl/scripted_server.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell {
namespace {

using test::dwell_event, test::Outcome, test::Program, test::Reply, test::run, test::sample_text, test::ScriptedServer,
    test::settling_text, test::stale_text;

TEST(WatchCommand, UntilThereAreEnoughDataTakesNoStaleOnesForThem) {
  ScriptedServer server({Reply{test::stream_header() + dwell_event(stale_text()), true}});
  const Outcome outcome = run({"watch", "--url", server.url(), "--until", "20"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("stale, from 5.7 s ago"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("thread estimate has not turned"), std::string::npos) << outcome.err;
}

TEST(WatchCommand, SaysThatTheEstimationIsSilentAndShowsNoneOfItsOldNumbers) {
  ScriptedServer server({Reply{test::stream_header() + dwell_event(stale_text()), true}});
  const Outcome outcome = run({"watch", "--url", server.url(), "--until", "20"});
  EXPECT_NE(outcome.out.find(" · the estimation publishes nothing new\n"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("kN/m"), std::string::npos) << outcome.out;
}

TEST(WatchCommand, SaysTheResultOfARunThatWasStoppedOnce) {
  Dwell dwell = test::sample_dwell();
  dwell.state = State::complete;
  dwell.ended_by = EndedBy::end;
  dwell.settling_reason = "the run was stopped";
  const std::string ended = dwell_event(to_json(dwell, test::sample_rig(), test::sample_run()));
  ScriptedServer server(
      {Reply{test::stream_header() + dwell_event(settling_text()) + ended + ended + ended + ended, true}});
  const Outcome outcome = run({"watch", "--url", server.url(), "--interval", "0.01", "--limit", "2"});
  const auto first = outcome.out.find(" · not of now, ended: the run was stopped\n");
  ASSERT_NE(first, std::string::npos) << outcome.out;
  const auto numbers = outcome.out.find("kN/m");
  ASSERT_NE(numbers, std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("complete, ended by", outcome.out.find("complete, ended by") + 1), std::string::npos)
      << outcome.out;
}

TEST(WatchCommand, AppendsWhereThereIsNoTerminalAndComesBackAfterARestart) {
  ScriptedServer server({Reply{test::stream_header() + dwell_event(settling_text())},
                         Reply{test::stream_header() + dwell_event(sample_text()), true}});
  const Outcome outcome = run({"watch", "--url", server.url(), "--until", "20", "--limit", "60"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("about 3.2 s left"), std::string::npos);
  EXPECT_NE(outcome.out.find("the service closed the stream"), std::string::npos);
  EXPECT_NE(outcome.out.find("connected again"), std::string::npos);
  EXPECT_NE(outcome.out.find("24.6 s of data"), std::string::npos);
  EXPECT_EQ(outcome.out.find('\x1b'), std::string::npos) << "no terminal, no control sequences";
}

TEST(WatchCommand, AppendsEachEstimateFromTheTransientOnce) {
  DwellView next = test::settling_view();
  auto longer = std::make_shared<MotionView>(*next.transient);
  longer->estimate.end_s += 1.6;
  next.transient = longer;
  DwellView none = next;
  auto refused = std::make_shared<MotionView>();
  refused->estimate.reason = "too few readings: 30";
  none.transient = refused;
  const std::string first = dwell_event(to_json(test::settling_view())), second = dwell_event(to_json(next)),
                    third = dwell_event(to_json(none));
  ScriptedServer server({Reply{
      test::stream_header() + first + first + second + second + third + third + dwell_event(sample_text()), true}});
  const Outcome outcome = run({"watch", "--url", server.url(), "--interval", "3600", "--until", "20"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto times = [&outcome](const std::string& text) {
    int count = 0;
    for (auto at = outcome.out.find(text); at != std::string::npos; at = outcome.out.find(text, at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(times("from the transient, 40.0 to 43.2 s"), 1) << outcome.out;
  EXPECT_EQ(times("from the transient, 40.0 to 44.8 s"), 1);
  EXPECT_EQ(times("from the transient: no coefficients"), 1);
}

TEST(WatchCommand, EndsWithCtrlC) {
  ScriptedServer server({Reply{test::stream_header() + dwell_event(sample_text()), true}});
  Program watch({"watch", "--url", server.url()});
  for (int i = 0; i < 3000 && watch.out().find("24.6 s of data") == std::string::npos; ++i) ::usleep(10'000);
  watch.interrupt();
  const Outcome outcome = watch.wait();
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("24.6 s of data"), std::string::npos);
}

TEST(WatchCommand, AsJsonIsOneObjectPerLine) {
  ScriptedServer server(
      {Reply{test::stream_header() + dwell_event(settling_text()) + dwell_event(sample_text()), true}});
  const Outcome outcome = run({"watch", "--json", "--url", server.url(), "--until", "20"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, settling_text() + "\n" + sample_text() + "\n");
}

TEST(WatchCommand, JudgesByTheTruth) {
  const test::TemporaryFolder folder;
  const std::string truth = folder.file("truth", R"({"stiffness":[24000,1,1],"damping":[60,1,1]})");
  ScriptedServer server({Reply{test::stream_header() + dwell_event(sample_text()), true}});
  const Outcome outcome = run({"watch", "--url", server.url(), "--until", "20", "--truth", truth});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.out.find("+0.7 u"), std::string::npos);
  EXPECT_NE(outcome.err.find("element 2 is not identifiable"), std::string::npos);
}

TEST(WatchCommand, GivesUpAtItsLimit) {
  ScriptedServer server({Reply{test::stream_header() + dwell_event(settling_text()), true}});
  const Outcome outcome = run({"watch", "--url", server.url(), "--until", "20", "--limit", "0.3"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("not enough data within the time allowed"), std::string::npos);
}

}  // namespace
}  // namespace dwell
