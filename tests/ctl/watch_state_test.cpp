#include "daemon/ctl/watch_state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/record/utc_text.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell::ctl {
namespace {

DwellView view_until(double end_s) {
  Dwell dwell = test::sample_dwell();
  dwell.end_s = end_s;
  return make_view(dwell, test::sample_rig(), test::sample_run());
}

TEST(WatchState, NumbersAreOldOnceTheServiceFallsSilent) {
  WatchState state;
  for (int i = 0; i <= 10; ++i) state.take(view_until(31.0 + 0.1 * i), 100.0 + 0.1 * i);
  EXPECT_FALSE(state.old(101.1));
  EXPECT_FALSE(state.old(103.4));
  EXPECT_TRUE(state.old(103.6));
  EXPECT_TRUE(state.silent(103.6));
  EXPECT_DOUBLE_EQ(state.age_s(879.0), 778.0);
}

// A service whose thread of estimation hangs goes on telling the same dwell.
TEST(WatchState, NumbersAreOldWhileTheServiceRepeatsThem) {
  WatchState state;
  for (int i = 0; i <= 50; ++i) state.take(view_until(31.0), 100.0 + 0.1 * i);
  EXPECT_TRUE(state.old(105.0));
  EXPECT_FALSE(state.silent(105.0));
  EXPECT_DOUBLE_EQ(state.age_s(105.0), 5.0);
}

// The service told the same for minutes before watch began.
TEST(WatchState, AStaleDwellIsOldAtOnceWithTheAgeThatTheServiceStates) {
  WatchState state;
  DwellView stale = view_until(31.0);
  stale.age = LiveAge{678.0, true};
  state.take(stale, 100.0);
  EXPECT_TRUE(state.old(100.0));
  EXPECT_DOUBLE_EQ(state.age_s(101.0), 679.0);
  EXPECT_EQ(state.silence(101.0), Silence::estimation);
  DwellView fresh = view_until(700.0);
  fresh.age = LiveAge{0.0, false};
  state.take(fresh, 102.0);
  EXPECT_FALSE(state.old(102.0));
  EXPECT_DOUBLE_EQ(state.age_s(102.0), 0.0);
}

// Of a service so old that it does not say how old its dwell is.
TEST(WatchState, SaysWhoIsSilent) {
  WatchState state;
  state.take(view_until(31.0), 100.0);
  state.take(std::vector<ChannelState>(), 103.0);
  EXPECT_TRUE(state.old(103.0));
  EXPECT_EQ(state.silence(103.0), Silence::estimation);
  EXPECT_EQ(state.silence(105.6), Silence::service);
  state.take(view_until(31.0), 106.0);
  EXPECT_EQ(state.silence(106.0), Silence::data);
  EXPECT_TRUE(state.old(106.0));
}

TEST(WatchState, WithoutAConnectionNumbersAreOldAtOnce) {
  WatchState state;
  state.take(view_until(31.0), 100.0);
  EXPECT_FALSE(state.old(100.1));
  state.trouble = "Connection refused";
  EXPECT_TRUE(state.old(100.1));
}

// estimation.update may be as long as an hour; but one outage does not make outages usual.
TEST(WatchState, ARigThatIsRarelyEstimatedIsNotOldBetweenItsEstimates) {
  WatchState state;
  for (int i = 0; i < 5; ++i) state.take(view_until(31.0 + 10.0 * i), 100.0 + 10.0 * i);
  EXPECT_FALSE(state.old(164.0));
  EXPECT_TRUE(state.old(166.0));

  WatchState after_an_outage;
  for (const double at_s : {100.0, 100.1, 700.0, 700.1}) after_an_outage.take(view_until(at_s), at_s);
  EXPECT_TRUE(after_an_outage.old(703.0));
}

TEST(WatchState, IdleIsNotOldWhileTheServiceSaysSo) {
  WatchState state;
  for (int i = 0; i <= 10; ++i) state.take(make_view(Dwell{}, test::sample_rig(), {}), 100.0 + i);
  EXPECT_FALSE(state.old(110.5));
  EXPECT_TRUE(state.old(113.0));
}

// With all devices gone the service says "fault" as of now: that is no old news.
TEST(WatchState, AFaultIsNotOldWhileTheServiceSaysSo) {
  WatchState state;
  Dwell fault;
  fault.state = State::fault;
  fault.end_s = 31.0;
  for (int i = 0; i <= 10; ++i) state.take(make_view(fault, test::sample_rig(), {}), 100.0 + i);
  EXPECT_FALSE(state.old(110.5));
}

TEST(WatchState, TheDwellOfARunThatWasStoppedIsAResultAsOldAsItsEnd) {
  WatchState state;
  DwellView stopped = view_until(31.0);  // of a run that began at 08:00:00
  stopped.dwell.state = State::complete;
  for (int i = 0; i <= 50; ++i) state.take(stopped, 100.0 + 0.1 * i);
  EXPECT_TRUE(state.ended());
  EXPECT_FALSE(state.old(105.0));
  EXPECT_TRUE(std::isnan(state.ended_ago_s(105.0))) << "the service's time is not known yet";
  state.take_utc(*record::parse_utc("2026-11-21T08:01:27Z"), 105.0);
  EXPECT_DOUBLE_EQ(state.ended_ago_s(105.0), 56.0);
  EXPECT_DOUBLE_EQ(state.ended_ago_s(106.0), 57.0);
  EXPECT_TRUE(state.old(108.0));  // the service has fallen silent
  state.take(view_until(32.0), 109.0);
  EXPECT_FALSE(state.ended());
  EXPECT_TRUE(std::isnan(state.ended_ago_s(109.0)));
}

// The service was started again with corrected masses: the numbers before are of the wrong ones.
TEST(WatchState, ForgetsTheDwellsOfARigThatIsServedNoLonger) {
  WatchState state;
  EXPECT_FALSE(state.take_rig("bench 3", "a0"));
  state.take(view_until(31.0), 100.0);
  state.take_last(view_until(20.0));
  EXPECT_FALSE(state.take_rig("bench 3", "a0"));
  EXPECT_TRUE(state.dwell());
  EXPECT_TRUE(state.take_rig("bench 3", "b1"));
  EXPECT_FALSE(state.dwell());
  EXPECT_EQ(state.last(), nullptr);
  EXPECT_TRUE(state.trend().section(view_until(31.0), 101.0, 120).body.empty());
}

TEST(WatchState, AModelWithoutAVerdictHasTheFirstReason) {
  WatchState state;
  DwellView view = view_until(31.0);
  view.model = ModelVerdict{Verdict::not_verified, {}, 0.05, kNaN, kNaN};
  state.take(view, 100.0);
  EXPECT_EQ(state.why_unverified(), "") << "not known yet";
  const auto told = [&](const char* json) {
    state.take(why_unverified(nlohmann::ordered_json::parse(json)));
    return state.why_unverified();
  };
  EXPECT_EQ(told(R"({"dwell":1,"reasons":["the transient is too weak","y1: U is too large"]})"),
            "the transient is too weak");
  EXPECT_EQ(told(R"({"dwell":null,"reasons":["its model is being verified"]})"), "its model is being verified");
  EXPECT_EQ(told(R"({"dwell":7,"reasons":["of the dwell before"]})"), "it is being verified");
  EXPECT_EQ(told(R"({"dwell":1,"reasons":[]})"), "no reason stated");
  EXPECT_EQ(told("7"), "no reason stated");
  view.model->verdict = Verdict::adequate;
  state.take(view, 101.0);
  EXPECT_EQ(state.why_unverified(), "");
}

TEST(WatchState, AChannelGrowsOlderFromWhatTheListSaid) {
  WatchState state;
  EXPECT_FALSE(state.channel("y0", 1.0));
  state.take(channel_states(nlohmann::ordered_json::parse(
                 R"([{"name":"y0","status":"ok","reason":null,"text":"ok","age_s":0.01},
                     {"name":"y1","status":"timeout","reason":"no answer within 0.1 s",
                      "text":"timeout: no answer within 0.1 s","age_s":12.0},
                     {"name":"y2","status":"clipped","reason":null,"text":"clipped","age_s":null}, 7, {"name":3}])")),
             100.0);
  EXPECT_EQ(state.channel("y0", 100.5)->status, "");
  EXPECT_DOUBLE_EQ(state.channel("y0", 100.5)->age_s, 0.51);
  EXPECT_EQ(state.channel("y1", 101.0)->status, "timeout: no answer within 0.1 s");
  EXPECT_DOUBLE_EQ(state.channel("y1", 101.0)->age_s, 13.0);
  EXPECT_EQ(state.channel("y2", 101.0)->status, "clipped");
  EXPECT_FALSE(state.channel("none", 101.0));
  EXPECT_TRUE(channel_states(nlohmann::ordered_json(7)).empty());
}

}  // namespace
}  // namespace dwell::ctl
