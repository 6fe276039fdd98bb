// One ordered stream from devices with clocks of their own, edges, states and ticks.
#include "core/stream/assembler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

namespace dwell {
namespace {

constexpr std::int64_t kMs = 1'000'000;

Record sample_at(std::int64_t t_ns, std::uint16_t channel) {
  Record record;
  record.t_ns = t_ns;
  record.channel = channel;
  return record;
}

Record state(std::int64_t t_ns, std::uint16_t channel) {
  Record record = sample_at(t_ns, channel);
  record.kind = Kind::channel_state;
  return record;
}

// Two devices: the first is dated by the host, the second by a clock of its own at 100 Hz.
struct Stream {
  Assembler assembler{{{Clock::host, {0}, 0.0, false}, {Clock::device, {1}, 100.0, false}}, 500 * kMs, 1024};
  std::map<Merger::Admission, int> admissions;
  int marked = 0;
  std::vector<Record> out;

  void give(std::size_t device, const Record& record) {
    assembler.sample(
        device, record, [this](Record&) { ++marked; },
        [this](const Record&, Merger::Admission admission) { ++admissions[admission]; });
  }
  void stop(std::size_t device) {
    assembler.stopped(
        device, [this](Record&) { ++marked; },
        [this](const Record&, Merger::Admission admission) { ++admissions[admission]; });
  }
  void take(bool everything = false) {
    for (Record record; everything ? assembler.flush(record) : assembler.next(record);) out.push_back(record);
  }
  [[nodiscard]] bool in_order() const {
    return std::is_sorted(out.begin(), out.end(), [](const Record& a, const Record& b) { return a.t_ns < b.t_ns; });
  }
};

// A hundred scans of the first device, taken as far as they are released; the second has stopped.
void run_first_device_for_a_second(Stream& stream) {
  stream.stop(1);
  for (int i = 0; i < 100; ++i) {
    stream.give(0, sample_at(i * 10 * kMs, 0));
    stream.assembler.tick(i * 10 * kMs);
    stream.assembler.edges_seen_to(i * 10 * kMs);
  }
  stream.take();
}

// Every eleventh answer of the second device comes 3 ms late; its instants come out on its own grid.
TEST(Assembler, EverySampleComesOutOnceInTheOrderOfRecoveredInstants) {
  Stream stream;
  for (int i = 0; i < 2000; ++i) {
    const std::int64_t t_ns = i * 10 * kMs;
    stream.give(0, sample_at(t_ns + 2 * kMs, 0));
    stream.give(1, sample_at(t_ns + (i % 11 == 0 ? 3 * kMs : 0), 1));
    stream.assembler.tick(t_ns + 5 * kMs);
    stream.take();
  }
  stream.stop(0);
  stream.stop(1);
  stream.take(true);
  EXPECT_TRUE(stream.in_order());
  EXPECT_EQ(stream.marked, 4000);
  EXPECT_EQ(stream.admissions[Merger::Admission::queued], 4000);
  int late = 0, of_second = 0;
  for (const Record& record : stream.out) {
    if (record.kind != Kind::sample || record.channel != 1 || record.t_ns < 5000 * kMs) continue;
    ++of_second;
    late += record.t_ns % (10 * kMs) > kMs && record.t_ns % (10 * kMs) < 9 * kMs;
  }
  EXPECT_EQ(of_second, 1500);
  EXPECT_EQ(late, 0);
}

TEST(Assembler, AStateThatComesLateStillComesAndASampleThatDoesIsToldToBeLate) {
  Stream stream;
  run_first_device_for_a_second(stream);
  ASSERT_FALSE(stream.out.empty());
  const std::int64_t released_ns = stream.out.back().t_ns;
  EXPECT_TRUE(stream.assembler.state(0, state(released_ns - 50 * kMs, 0)));
  stream.give(0, sample_at(released_ns - 50 * kMs, 0));
  EXPECT_EQ(stream.admissions[Merger::Admission::late], 1);
  stream.take(true);
  EXPECT_TRUE(stream.in_order());
  EXPECT_EQ(std::count_if(stream.out.begin(), stream.out.end(),
                          [](const Record& record) { return record.kind == Kind::channel_state; }),
            1);
}

TEST(Assembler, AnEdgeThatComesLateIsToldToBeLateAndAnUrgentOneComesStill) {
  Stream stream;
  run_first_device_for_a_second(stream);
  Record edge = sample_at(stream.out.back().t_ns - 50 * kMs, 0);
  edge.kind = Kind::edge;
  EXPECT_EQ(stream.assembler.edge(edge), Merger::Admission::late);
  EXPECT_TRUE(stream.assembler.urgent_edge(edge));
  Record action = edge;
  action.kind = Kind::action;
  EXPECT_TRUE(stream.assembler.action(action));
  const std::size_t before = stream.out.size();
  stream.take(true);
  EXPECT_TRUE(stream.in_order());
  EXPECT_EQ(std::count_if(stream.out.begin() + static_cast<std::ptrdiff_t>(before), stream.out.end(),
                          [](const Record& record) { return record.kind == Kind::edge; }),
            1);
}

TEST(Assembler, WhereThereIsNoRoomAStateIsGivenBackAndASampleIsToldSo) {
  Stream stream;
  for (int i = 0; i < 1100; ++i) stream.give(0, sample_at(i * kMs / 100, 0));
  EXPECT_EQ(stream.admissions[Merger::Admission::queued], 1024);
  EXPECT_EQ(stream.admissions[Merger::Admission::full], 76);
  EXPECT_FALSE(stream.assembler.state(0, state(11 * kMs, 0)));
}

TEST(Assembler, ADeviceThatHasStoppedIsNotWaitedFor) {
  Stream stream;
  stream.give(1, sample_at(0, 1));
  for (int i = 0; i < 20; ++i) {
    stream.give(0, sample_at(i * 10 * kMs, 0));
    stream.assembler.tick(i * 10 * kMs);
    stream.assembler.edges_seen_to(i * 10 * kMs);
  }
  stream.take();
  const std::size_t waiting = stream.out.size();
  stream.stop(1);
  stream.take();
  EXPECT_LE(waiting, 3u);
  EXPECT_GT(stream.out.size(), 19u);
}

TEST(Assembler, TheSourcesOfARigAreItsDevicesWithTheirChannels) {
  Rig rig;
  rig.devices.resize(2);
  rig.devices[1].clock = Clock::device;
  rig.devices[1].rate_hz = 200.0;
  rig.channels.resize(4);
  rig.channels[0].device = 1;
  rig.channels[1].device = 0;
  rig.channels[2].device = 1;
  rig.channels[3].device = -1;
  const auto sources = Assembler::sources(rig);
  ASSERT_EQ(sources.size(), 2u);
  EXPECT_EQ(sources[0].channels, (std::vector<std::uint16_t>{1}));
  EXPECT_EQ(sources[1].channels, (std::vector<std::uint16_t>{0, 2}));
  EXPECT_EQ(sources[1].clock, Clock::device);
  EXPECT_EQ(sources[1].rate_hz, 200.0);
}

}  // namespace
}  // namespace dwell
