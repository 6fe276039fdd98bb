// What comes of the ordered stream: events and snapshots on their way out of the estimation thread.
#include "daemon/estimate/measurement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "daemon/estimate/publisher.hpp"
#include "tests/daemon/one_mass_rig.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

struct MeasurementTest : testing::Test {
  MeasurementTest() {
    for (Channel& channel : rig.channels) {
      channel.range.low = -5e-3;
      channel.range.high = 5e-3;
    }
    measurement.emplace(rig, KeptDwells(10, 1'000'000), [this](RunEvent event) { events.push_back(std::move(event)); });
  }
  void sample(int channel, double value) {
    Record record;
    record.t_ns = t_ns;
    record.channel = static_cast<std::uint16_t>(channel);
    record.value = value;
    measurement->take(record);
  }
  void go_on(std::int64_t for_ns) {
    for (const std::int64_t end_ns = t_ns + for_ns; t_ns < end_ns; t_ns += 5 * kMs_ns) {
      const double angle = 20.0 * std::numbers::pi * static_cast<double>(t_ns) * 1e-9;
      sample(0, 1e-3 * std::sin(angle));
      sample(1, 1.5e-3 * std::sin(angle - 0.4));
    }
  }

  Rig rig = test::one_mass_rig();
  std::int64_t t_ns = kSecond_ns;
  std::vector<RunEvent> events;
  std::optional<Measurement> measurement;
};

TEST_F(MeasurementTest, TellsEveryChangeOfStateInAChainAndTheDwellThatEnds) {
  go_on(10 * kSecond_ns);
  ASSERT_EQ(measurement->pipeline().state(), State::measuring);
  measurement->finish();
  State state = State::idle;
  int finished = 0;
  for (const RunEvent& event : events) {
    ASSERT_TRUE(event.dwell);
    if (event.kind == RunEvent::Kind::state_changed) {
      EXPECT_EQ(event.before, state);
      EXPECT_NE(event.dwell->state, event.before);
      state = event.dwell->state;
    } else {
      ++finished;
      EXPECT_EQ(event.dwell->ended_by, EndedBy::end);
      EXPECT_EQ(event.dwell, measurement->finished().list()->back()) << "one object, not two";
    }
  }
  EXPECT_EQ(finished, 1);
  EXPECT_EQ(state, measurement->pipeline().state());
}

TEST_F(MeasurementTest, EverySampleTakenIsUsedOrRejected) {
  go_on(2 * kSecond_ns);
  sample(0, 1.0);  // far beyond its range
  t_ns += 5 * kMs_ns;
  go_on(2 * kSecond_ns);
  const Measurement::Fate fate = measurement->fate(0);
  EXPECT_EQ(fate.used + fate.rejected, 801u);
  EXPECT_GE(fate.rejected, 1u);
  EXPECT_EQ(measurement->fate(1).rejected, 0u);
}

TEST(Publisher, TheReaderSeesTheNewestSnapshotAndItsNumber) {
  int woken = 0;
  Publisher publisher([&woken] { ++woken; });
  EXPECT_FALSE(publisher.refresh());
  for (int i = 1; i <= 3; ++i) {
    publisher.next().t_ns = i;
    publisher.publish();
  }
  EXPECT_TRUE(publisher.refresh());
  EXPECT_EQ(publisher.latest().t_ns, 3);
  EXPECT_EQ(publisher.latest().sequence, 3u);
  EXPECT_FALSE(publisher.refresh());
  EXPECT_EQ(woken, 3);
}

TEST(Publisher, EveryEventIsSeenAndWhatFindsNoRoomIsCounted) {
  Publisher publisher([] {});
  const auto dwell = std::make_shared<const Dwell>();
  for (std::size_t i = 0; i < Publisher::kEvents + 6; ++i)
    publisher.tell({RunEvent::Kind::dwell_finished, State::idle, dwell});
  std::size_t seen = 0;
  RunEvent event;
  for (; publisher.next_event(event); ++seen) EXPECT_EQ(event.lost, 0u);
  EXPECT_EQ(seen, Publisher::kEvents);
  for (const std::uint64_t lost : {6u, 0u}) {
    publisher.tell({RunEvent::Kind::dwell_finished, State::idle, dwell});
    ASSERT_TRUE(publisher.next_event(event));
    EXPECT_EQ(event.lost, lost);
  }
}

}  // namespace
}  // namespace dwell
