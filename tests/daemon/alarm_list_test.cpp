// Alarms as ISA-18.2 has them: what lasts is one, it waits for an operator, and what flaps stays one.
#include "daemon/alarms/alarm_list.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/durations.hpp"

namespace dwell {
namespace {

struct AlarmListTest : testing::Test {
  [[nodiscard]] record::ClockPair now() const { return {t_ns, 1'700'000'000 * kSecond_ns + t_ns}; }
  // Time goes on with these troubles, looked at ten times a second.
  void run(const std::vector<Trouble>& troubles, int tenths, const std::vector<Trouble>& unknown = {}) {
    for (int i = 0; i < tenths; ++i) {
      t_ns += kSecond_ns / 10;
      for (AlarmChange& change : list.follow(troubles, unknown, now())) told.push_back(std::move(change));
    }
  }
  void last(const std::vector<Trouble>& troubles) { run(troubles, 11); }
  void rest() { run({}, 11); }
  // The reason why not; empty: it is done.
  std::string acknowledge(const std::string& name) {
    const auto done = list.acknowledge(name, "anna (uid 1000)", "seen", now());
    return done ? "" : done.error();
  }
  [[nodiscard]] std::string all() const {
    std::string text;
    for (const Alarm& alarm : list.alarms())
      text +=
          (text.empty() ? "" : ", ") + alarm.name + " " + to_string(alarm.state) + " " + std::to_string(alarm.count);
    return text;
  }
  [[nodiscard]] std::string changes() const {
    std::string text;
    for (const AlarmChange& change : told)
      text += (text.empty() ? "" : ", ") + change.alarm.name + " " + to_string(change.before) + " -> " +
              to_string(change.alarm.state);
    return text;
  }

  const Trouble stale{"channel:y1", "channel y1: timeout"};
  const Trouble full{"recording", "the run is not recorded: disk full"};
  const Trouble withheld{"channel:y1", "channel y1: not known"};
  std::int64_t t_ns = 5 * kSecond_ns;
  AlarmList list;
  std::vector<AlarmChange> told;
};

TEST(AlarmStates, EveryInputHasOneConsequenceInEveryState) {
  using S = AlarmState;
  using I = AlarmInput;
  const struct {
    S state;
    I input;
    S after;
  } table[] = {{S::normal, I::lasts, S::unacknowledged},
               {S::normal, I::gone, S::normal},
               {S::normal, I::acknowledge, S::normal},
               {S::unacknowledged, I::lasts, S::unacknowledged},
               {S::unacknowledged, I::gone, S::returned},
               {S::unacknowledged, I::acknowledge, S::acknowledged},
               {S::acknowledged, I::lasts, S::acknowledged},
               {S::acknowledged, I::gone, S::normal},
               {S::acknowledged, I::acknowledge, S::acknowledged},
               {S::returned, I::lasts, S::unacknowledged},
               {S::returned, I::gone, S::returned},
               {S::returned, I::acknowledge, S::normal}};
  for (const auto& row : table)
    EXPECT_EQ(next(row.state, row.input), row.after) << to_string(row.state) << " " << static_cast<int>(row.input);
}

// A limit's number was withheld for 5 s: the alarm was over, and began anew without its acknowledgement.
TEST_F(AlarmListTest, AnAlarmAndItsAcknowledgementStayWhileNothingTellsOfIt) {
  last({stale});
  EXPECT_EQ(acknowledge("channel:y1"), "");
  run({}, 50, {withheld});
  EXPECT_EQ(all(), "channel:y1 acknowledged 1");
  EXPECT_EQ(list.alarms()[0].text, "channel y1: not known");
  last({stale});
  EXPECT_EQ(all(), "channel:y1 acknowledged 1");
  EXPECT_EQ(list.alarms()[0].text, "channel y1: timeout");
  run({}, 50, {withheld});
  rest();
  EXPECT_EQ(all(), "");
}

TEST_F(AlarmListTest, WhatNothingTellsOfIsNoAlarmAndDoesNotBringABackAnAlarmThatIsOver) {
  run({}, 50, {withheld});
  run({stale}, 9);
  run({}, 50, {withheld});
  EXPECT_EQ(all(), "");
  run({stale}, 4);  // the time before and after adds up
  rest();
  EXPECT_EQ(all(), "channel:y1 returned-unacknowledged 1");
  run({}, 50, {withheld});
  EXPECT_EQ(all(), "channel:y1 returned-unacknowledged 1");
  EXPECT_EQ(list.alarms()[0].text, "channel y1: timeout");
}

TEST_F(AlarmListTest, WhatIsWrongIsAnAlarmOnceItHasLastedASecond) {
  run({stale}, 10);
  EXPECT_EQ(all(), "");
  run({stale}, 1);
  EXPECT_EQ(all(), "channel:y1 unacknowledged 1");
  EXPECT_EQ(list.unacknowledged(), 1u);
}

TEST_F(AlarmListTest, WhatPassesWithinASecondIsNone) {
  for (int i = 0; i < 20; ++i) {
    run({stale}, 10);
    run({}, 40);
  }
  EXPECT_EQ(all(), "");
}

TEST_F(AlarmListTest, WhatComesAndGoesIsAnAlarmWhereItIsThereForMoreThanAFifthOfTheTime) {
  std::mt19937 random(20261123);
  std::uniform_int_distribution<int> tenths(2, 9);
  for (int round = 0; round < 200; ++round) {
    const int there = tenths(random), absent = tenths(random);
    list = {};
    for (int i = 0; i < 60; ++i) {
      run({stale}, there);
      run({}, absent);
    }
    // Of the looks that found it, the first of each time adds nothing.
    const bool adds_up = AlarmList::kFade * (there - 1) > absent + 1;
    EXPECT_EQ(list.alarms().size(), adds_up ? 1u : 0u) << there << " there, " << absent << " absent";
  }
}

TEST_F(AlarmListTest, ADeviceThatIsDeadThreeQuartersOfTheTimeIsOneAlarmToldOnce) {
  const Trouble dead{"device:amplifier", "device amplifier does not deliver: timeout"};
  for (int i = 0; i < 100; ++i) {
    run({dead}, 9);
    run({}, 3);
  }
  EXPECT_EQ(all(), "device:amplifier unacknowledged 1");
  EXPECT_EQ(acknowledge("device:amplifier"), "");
  for (int i = 0; i < 100; ++i) {
    run({dead}, 9);
    run({}, 3);
  }
  EXPECT_EQ(all(), "device:amplifier acknowledged 1") << "an alarm returns once its trouble was absent for a second";
  EXPECT_EQ(told.size(), 1u);
  run({}, 10);
  EXPECT_EQ(all(), "");
}

TEST_F(AlarmListTest, AnAcknowledgedAlarmGoesWithItsCause) {
  last({stale});
  EXPECT_EQ(acknowledge("channel:y1"), "");
  EXPECT_EQ(all(), "channel:y1 acknowledged 1");
  EXPECT_EQ(list.unacknowledged(), 0u);
  EXPECT_EQ(list.alarms()[0].acknowledged_by, "anna (uid 1000)");
  rest();
  EXPECT_EQ(all(), "");
  EXPECT_EQ(changes(), "channel:y1 normal -> unacknowledged, channel:y1 acknowledged -> normal");
}

TEST_F(AlarmListTest, OneThatReturnsUnseenWaitsForItsAcknowledgement) {
  last({stale});
  run({}, 100);
  EXPECT_EQ(all(), "channel:y1 returned-unacknowledged 1");
  EXPECT_EQ(list.unacknowledged(), 1u);
  EXPECT_EQ(acknowledge("channel:y1"), "");
  EXPECT_EQ(all(), "");
}

TEST_F(AlarmListTest, WhatFlapsIsOneAlarmWithACountAndToldOnce) {
  const std::int64_t first_utc_ns = now().utc_ns + AlarmList::kLasts_ns + kSecond_ns / 10;
  for (int i = 0; i < 500; ++i) {
    last({stale});
    rest();
  }
  EXPECT_EQ(all(), "channel:y1 returned-unacknowledged 500");
  EXPECT_EQ(list.alarms()[0].since_utc_ns, first_utc_ns);
  EXPECT_EQ(changes(), "channel:y1 normal -> unacknowledged, channel:y1 unacknowledged -> returned-unacknowledged");
}

TEST_F(AlarmListTest, TheWordsFollowTheTroubleWithoutAnotherAlarm) {
  last({stale});
  last({{"channel:y1", "channel y1: disconnected"}});
  EXPECT_EQ(list.alarms()[0].text, "channel y1: disconnected");
  EXPECT_EQ(told.size(), 1u);
}

TEST_F(AlarmListTest, ThoseThatWaitComeFirstAndOfTheseTheNewest) {
  last({full});
  EXPECT_EQ(acknowledge("recording"), "");
  last({full, {"clock", ""}});
  last({full, stale});
  last({full, stale, {"log", ""}});
  EXPECT_EQ(all(),
            "log unacknowledged 1, channel:y1 unacknowledged 1, clock returned-unacknowledged 1, "
            "recording acknowledged 1");
}

TEST_F(AlarmListTest, WhatIsNotThereOrAcknowledgedCannotBeAcknowledged) {
  EXPECT_EQ(acknowledge("channel:y9"), "no alarm \"channel:y9\": expected one of the list of alarms");
  last({stale});
  EXPECT_EQ(acknowledge("channel:y1"), "");
  EXPECT_EQ(acknowledge("channel:y1"), "alarm channel:y1 has been acknowledged already, by anna (uid 1000)");
}

TEST_F(AlarmListTest, TheListIsBoundedAndCountsWhatFoundNoRoom) {
  std::vector<Trouble> many;
  for (std::size_t i = 0; i < AlarmList::kMost + 7; ++i) many.push_back({"channel:y" + std::to_string(1000 + i), ""});
  last(many);
  EXPECT_EQ(list.alarms().size(), AlarmList::kMost);
  EXPECT_EQ(list.left_out(), 7u);
  EXPECT_EQ(told.size(), AlarmList::kMost);
  // Where there is room again, one of them enters.
  const std::string first = list.alarms()[0].name;
  EXPECT_EQ(acknowledge(first), "");
  many.erase(std::find_if(many.begin(), many.end(), [&](const Trouble& t) { return t.name == first; }));
  run(many, 11);
  EXPECT_EQ(list.alarms().size(), AlarmList::kMost);
  EXPECT_EQ(list.left_out(), 6u);
}

}  // namespace
}  // namespace dwell
