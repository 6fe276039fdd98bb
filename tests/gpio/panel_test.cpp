#include "daemon/gpio/panel.hpp"

#include <gtest/gtest.h>

#include "tests/durations.hpp"
#include "tests/gpio/fake_lines.hpp"

namespace dwell::gpio {
namespace {

constexpr std::int64_t kOffset_ns = 700 * kSecond_ns;  // RAW over MONOTONIC

config::GpioLine line(unsigned number, double debounce_s = 0.0) {
  config::GpioLine line;
  line.chip = "/dev/gpiochip0";
  line.line = number;
  line.debounce_s = debounce_s;
  return line;
}

struct PanelTest : testing::Test {
  PanelTest() {
    LogOptions options;
    options.console = false;
    log = std::move(*Log::make(options));
    settings.interlock = line(0);
    settings.sync = line(1);
    settings.ready = line(2);
    settings.fault = line(3);
    lines[0].level = true;
  }
  Panel& start() {
    panel.emplace(settings, lines, link, *log);
    turn(0);
    return *panel;
  }
  // One turn at this instant of CLOCK_MONOTONIC; the order for the lamps is fresh.
  void turn(std::int64_t after_ns) {
    now_ns += after_ns;
    link.order(order, now_ns + kOffset_ns);
    panel->turn({now_ns + kOffset_ns, now_ns, 30});
    for (Record record; link.pop(record);) records.push_back(record);
  }
  [[nodiscard]] LineStatus status(Function function) const { return link.status()[static_cast<std::size_t>(function)]; }
  static bool is(const Record& record, Line line, double level, std::int64_t monotonic_ns) {
    return record.kind == Kind::edge && record.channel == static_cast<std::uint16_t>(line) && record.value == level &&
           record.t_ns == monotonic_ns + kOffset_ns;
  }

  std::unique_ptr<Log> log;
  config::GpioSettings settings;
  FakeLines lines;
  Link link;
  LampOrder order;
  std::optional<Panel> panel;
  std::int64_t now_ns = 100 * kSecond_ns;
  std::vector<Record> records;
};

TEST_F(PanelTest, TheInterlocksLevelAtTheStartIsTheFirstEdge) {
  start();
  ASSERT_EQ(records.size(), 1u);
  EXPECT_TRUE(is(records[0], Line::interlock, 1.0, now_ns));
  EXPECT_EQ(link.seen_to_ns(), now_ns + kOffset_ns - Panel::kLateness_ns);
  EXPECT_EQ(status(Function::interlock).level, true);
}

TEST_F(PanelTest, AnEdgeIsToldAtItsOwnInstantOnTheRawClock) {
  start();
  lines[0].edge(now_ns + 3'000'000, false);
  turn(5'000'000);
  ASSERT_EQ(records.size(), 2u);
  EXPECT_TRUE(is(records[1], Line::interlock, 0.0, now_ns - 2'000'000));
  EXPECT_EQ(records[1].flags, 0);
  EXPECT_EQ(records[1].t_half_ns, 30u);
}

TEST_F(PanelTest, AStampOutsideTheTimeSinceTheLastReadingIsReplacedAndFlagged) {
  start();
  turn(kSecond_ns / 2);
  for (const std::int64_t stamp_ns : {now_ns - kSecond_ns, now_ns + kSecond_ns}) {
    lines[1].edge(stamp_ns, true);
    turn(5'000'000);
    EXPECT_TRUE(is(records.back(), Line::sync, 1.0, now_ns));
    EXPECT_EQ(records.back().flags, kStampReplaced);
  }
}

TEST_F(PanelTest, EverySyncPulseIsOneEdgeAndItsEndIsNone) {
  settings.sync = line(1, 0.001);
  start();
  for (int i = 0; i < 5; ++i) {
    lines[1].edge(now_ns + 1'000'000, true);
    lines[1].edge(now_ns + 1'200'000, false);  // bounces
    lines[1].edge(now_ns + 1'400'000, true);
    lines[1].edge(now_ns + 6'000'000, false);
    lines[1].edge(now_ns + 6'100'000, true);
    lines[1].edge(now_ns + 6'200'000, false);
    turn(10'000'000);
    ASSERT_EQ(records.size(), 2u + static_cast<std::size_t>(i));
    EXPECT_TRUE(is(records.back(), Line::sync, 1.0, now_ns - 9'000'000));
  }
  EXPECT_EQ(status(Function::sync).edges, 5u);
  EXPECT_EQ(status(Function::sync).bounces, 20u);
}

TEST_F(PanelTest, WithoutDebounceOnlyRisingEdgesAreAskedFor) {
  start();
  EXPECT_TRUE(lines[1].rising);
  EXPECT_FALSE(lines[0].rising) << "of the interlock both matter";
  lines[1].edge(now_ns + 1'000'000, true);
  lines[1].edge(now_ns + 1'020'000, true);
  turn(5'000'000);
  EXPECT_EQ(records.size(), 3u) << "a pulse too short for its falling edge to be seen";
}

TEST_F(PanelTest, EdgesThatTheKernelLostAreFlaggedOnTheNextOne) {
  start();
  lines[1].edge(now_ns + 1'000'000, true, true);
  lines[1].edge(now_ns + 2'000'000, true);
  turn(5'000'000);
  ASSERT_EQ(records.size(), 3u);
  EXPECT_EQ(records[1].flags, kGap);
  EXPECT_EQ(records[2].flags, 0);
  EXPECT_EQ(status(Function::sync).lost, 1u);
}

TEST_F(PanelTest, WhatDoesNotFitIntoTheStreamIsCountedAndFlagged) {
  start();
  const std::size_t many = Link::kEdges + 100;
  for (std::size_t i = 0; i < many; ++i) lines[1].edge(now_ns + static_cast<std::int64_t>(i), true);
  while (!lines[1].edges.empty()) {
    now_ns += 1'000'000;
    panel->turn({now_ns + kOffset_ns, now_ns, 30});  // and nobody takes them
  }
  std::size_t taken = 0;
  for (Record record; link.pop(record);) ++taken;
  EXPECT_EQ(taken + status(Function::sync).lost, many);
  lines[1].edge(now_ns + 1, true);
  turn(1'000'000);
  EXPECT_EQ(records.back().flags, kGap);
}

TEST_F(PanelTest, TheLossOfTheInterlockIsToldOnceThereIsRoom) {
  start();
  for (std::size_t i = 0; i < Link::kEdges; ++i) link.push({});
  lines[0].edge(now_ns + 1, false);
  now_ns += 1'000'000;
  panel->turn({now_ns + kOffset_ns, now_ns, 30});
  EXPECT_EQ(status(Function::interlock).lost, 1u);
  for (Record record; link.pop(record);) {
  }
  turn(1'000'000);
  EXPECT_TRUE(is(records.back(), Line::interlock, 0.0, now_ns));
  EXPECT_EQ(records.back().flags, kGap);
  const std::size_t told = records.size();
  turn(1'000'000);
  EXPECT_EQ(records.size(), told) << "once";
  EXPECT_EQ(status(Function::interlock).lost, 1u);
}

TEST_F(PanelTest, ALineThatBabblesDoesNotKeepATurnBusyForEver) {
  start();
  for (int i = 0; i < 10'000; ++i) lines[1].edge(now_ns + i, true);
  turn(1'000'000);
  EXPECT_LT(records.size(), 1000u);
  EXPECT_FALSE(lines[1].edges.empty());
}

TEST_F(PanelTest, AnInterlockEdgeThatNeverCameIsFoundByReadingTheLevel) {
  start();
  lines[0].level = false;
  turn(Panel::kProbe_ns);
  EXPECT_TRUE(is(records.back(), Line::interlock, 0.0, now_ns));
  EXPECT_EQ(status(Function::interlock).lost, 1u);
}

TEST_F(PanelTest, ALineThatCannotBeHadIsToldAndTriedAgainAndTheRestWorks) {
  lines[0].fault = "line 0 of /dev/gpiochip0 is in use by \"other\"";
  lines[2].fault = "there is no /dev/gpiochip0";
  start();
  EXPECT_TRUE(records.empty()) << "without an interlock nothing is said of it";
  EXPECT_FALSE(status(Function::interlock).works);
  EXPECT_EQ(status(Function::interlock).reason, lines[0].fault);
  EXPECT_FALSE(status(Function::ready).works);
  EXPECT_TRUE(status(Function::sync).works);
  EXPECT_TRUE(status(Function::fault).works);
  const std::uint64_t lines_told = log->stats().lines;
  turn(Panel::kRetry_ns);
  turn(Panel::kRetry_ns);
  EXPECT_EQ(log->stats().lines, lines_told) << "the same reason is told once";

  lines[0].fault.clear();
  turn(Panel::kRetry_ns);
  EXPECT_TRUE(status(Function::interlock).works);
  EXPECT_TRUE(is(records.back(), Line::interlock, 1.0, now_ns));
}

TEST_F(PanelTest, AnInterlockThatBreaksCountsAsLost) {
  start();
  lines[0].fault = "the chip has gone";
  turn(5'000'000);
  EXPECT_TRUE(is(records.back(), Line::interlock, 0.0, now_ns));
  EXPECT_FALSE(status(Function::interlock).works);
  EXPECT_EQ(status(Function::interlock).level, std::nullopt);
  EXPECT_FALSE(lines[0].held) << "let go, so that it can be had again";
  turn(Panel::kRetry_ns);
  EXPECT_EQ(records.size(), 2u) << "lost is said once";
}

TEST_F(PanelTest, TheReadyLampBlinksUntilItIsSteady) {
  start();
  int changes = 0;
  for (bool before = lines[2].level; now_ns < 110 * kSecond_ns; before = lines[2].level) {
    turn(10'000'000);
    if (lines[2].level != before) ++changes;
  }
  EXPECT_EQ(changes, 20) << "once a second on and off";
  order.ready = true;
  turn(10'000'000);
  for (int i = 0; i < 200; ++i) {
    EXPECT_TRUE(lines[2].level);
    turn(10'000'000);
  }
}

TEST_F(PanelTest, TheFaultLampFollowsTheOrder) {
  start();
  EXPECT_FALSE(lines[3].level);
  order.fault = true;
  turn(10'000'000);
  EXPECT_TRUE(lines[3].level);
  order.fault = false;
  turn(10'000'000);
  EXPECT_FALSE(lines[3].level);
}

TEST_F(PanelTest, ALampWhoseChipHasGoneIsFoundThoughNothingChanges) {
  order.ready = true;
  start();
  lines[3].fault = "the chip has gone";
  turn(Panel::kProbe_ns);
  EXPECT_FALSE(status(Function::fault).works);
  EXPECT_FALSE(lines[3].held);
  lines[3].fault.clear();
  turn(Panel::kRetry_ns);
  EXPECT_TRUE(status(Function::fault).works);
}

TEST_F(PanelTest, AServiceThatHangsNeitherBlinksNorIsReady) {
  order.ready = true;
  start();
  EXPECT_TRUE(lines[2].level);
  for (int i = 0; i < 500; ++i) {
    now_ns += 10'000'000;
    panel->turn({now_ns + kOffset_ns, now_ns, 30});  // nobody orders anything
    if (i * std::int64_t{10'000'000} <= kFresh_ns) continue;
    EXPECT_FALSE(lines[2].level);
    EXPECT_TRUE(lines[3].level);
  }
}

TEST_F(PanelTest, TheEndDarkensTheLamps) {
  order = {true, true};
  start();
  EXPECT_TRUE(lines[2].level && lines[3].level);
  panel.reset();
  EXPECT_FALSE(lines[2].level || lines[3].level);
  EXPECT_FALSE(lines[0].held || lines[1].held || lines[2].held || lines[3].held);
}

TEST_F(PanelTest, LampsOffDarkensWhatItCanAndTellsTheRest) {
  lines[2].level = lines[3].level = true;
  lines[2].fault = "line 2 of /dev/gpiochip0 is in use";
  EXPECT_EQ(lamps_off(settings, lines), std::vector<std::string>{lines[2].fault});
  EXPECT_FALSE(lines[3].level);
  EXPECT_TRUE(lamps_off({}, lines).empty()) << "without lamps there is nothing to do";
}

TEST_F(PanelTest, WithoutInputsNobodyIsMadeToWaitForEdges) {
  settings.interlock.reset();
  settings.sync.reset();
  start();
  EXPECT_FALSE(panel->has_inputs());
  EXPECT_EQ(link.seen_to_ns(), INT64_MIN);
}

}  // namespace
}  // namespace dwell::gpio
