// What the log and the file of the run learn of alarms.
#include "daemon/alarms/alarms.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/log_to_read.hpp"

namespace dwell {
namespace {

struct AlarmsTest : testing::Test {
  void look(const std::vector<Trouble>& troubles) {
    Health health;
    health.troubles = troubles;
    for (int i = 0; i < 2; ++i) {
      now.raw_ns += AlarmList::kLasts_ns;
      now.utc_ns += AlarmList::kLasts_ns;
      alarms.look(health, now);
    }
  }
  const std::vector<Trouble> stale{{"channel:y1", "channel y1: timeout"}};
  test::LogToRead log{"alarms"};
  std::vector<record::StoredEvent> events;
  Alarms alarms{log, [this](record::StoredEvent event) { events.push_back(std::move(event)); }};
  record::ClockPair now{1, 1};
};

TEST_F(AlarmsTest, EveryChangeStandsInTheLogAndInTheRun) {
  look(stale);
  look({});
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].what, "alarm");
  EXPECT_EQ(events[0].text, "alarm channel:y1: channel y1: timeout");
  EXPECT_EQ(events[0].before, "normal");
  EXPECT_EQ(events[0].after, "unacknowledged");
  EXPECT_EQ(events[1].after, "returned-unacknowledged");
  EXPECT_EQ(log.lines(), (std::vector<std::string>{"warning alarm channel:y1: channel y1: timeout",
                                                   "info alarm channel:y1 has returned, not acknowledged"}));
}

TEST_F(AlarmsTest, AnAcknowledgementIsAnActionOfAPersonBeforeAndAfter) {
  look(stale);
  look({});
  look(stale);
  ASSERT_TRUE(alarms.acknowledge("channel:y1", "cable pulled", {1000, "anna"}, now));
  const record::StoredEvent event = events.back();
  EXPECT_EQ(event.what, "action");
  EXPECT_EQ(event.text, "alarm channel:y1 acknowledged by anna (uid 1000), raised 2 times");
  ASSERT_TRUE(event.person);
  EXPECT_EQ(event.person->name, "anna");
  EXPECT_EQ(event.before, "unacknowledged");
  EXPECT_EQ(event.after, "acknowledged");
  EXPECT_EQ(event.comment, "cable pulled");
  look({});
  EXPECT_EQ(events.back().text, "alarm channel:y1 has returned, raised 2 times");
  EXPECT_EQ(events.back().after, "normal");
  const std::vector<std::string> lines = log.lines();
  ASSERT_GE(lines.size(), 2u);
  EXPECT_EQ(lines[lines.size() - 2], "info " + event.text + ": cable pulled");
}

TEST_F(AlarmsTest, WhatCannotBeAcknowledgedLeavesNoTrace) {
  EXPECT_FALSE(alarms.acknowledge("channel:y1", "", {1000, "anna"}, now));
  EXPECT_TRUE(events.empty());
  EXPECT_TRUE(log.lines().empty());
}

}  // namespace
}  // namespace dwell
