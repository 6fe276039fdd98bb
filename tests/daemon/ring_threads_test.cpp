// The books of a channel, looked at while two threads write them.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>

#include "daemon/acquire/device_link.hpp"

namespace dwell {
namespace {

TEST(DeviceLinkThreads, ReceivedIsUsedPlusDroppedPlusQueuedInEveryView) {
  constexpr std::uint64_t kScans = 200'000;
  constexpr std::size_t kCapacity = 64;  // small, so that refusals happen all the time
  DeviceLink link("amplifier", {0, 1}, kCapacity, nullptr);
  std::atomic<bool> done{false};

  std::thread device([&] {
    for (std::uint64_t i = 0; i < kScans; ++i) {
      const auto t = static_cast<std::int64_t>(i);
      const std::array<dwell_sample, 2> samples{dwell_sample{t, 0.0, 0, 0, 0}, dwell_sample{t, 0.0, 0, 1, 0}};
      link.push(samples.data(), samples.size());
      if (i % 64 == 0) std::this_thread::yield();
    }
    done.store(true, std::memory_order_release);
  });

  std::array<std::uint64_t, 2> used{};
  std::array<std::uint64_t, 2> rejected{};
  std::array<std::int64_t, 2> last{-1, -1};
  std::array<std::uint64_t, 2> jumps{};
  std::thread estimation([&] {
    std::array<Record, 32> records{};
    for (bool last_round = false;;) {
      const bool finished = done.load(std::memory_order_acquire);
      const std::size_t taken = link.pop_samples(records.data(), records.size());
      for (std::size_t i = 0; i < taken; ++i) {
        const auto c = static_cast<std::size_t>(records[i].channel);
        const bool jumped = records[i].t_ns != last[c] + 1;
        EXPECT_EQ(jumped, (records[i].flags & kGap) != 0) << "a gap is marked where samples are missing, nowhere else";
        jumps[c] += jumped ? 1 : 0;
        last[c] = records[i].t_ns;
        switch (records[i].t_ns % 7) {
          case 0:
            link.counters(static_cast<int>(c)).late();
            break;
          case 1:
            link.counters(static_cast<int>(c)).overflow();
            break;
          case 2:
            ++rejected[c];
            break;
          default:
            ++used[c];
        }
      }
      for (std::size_t c = 0; c < 2; ++c) link.counters(static_cast<int>(c)).settle(used[c], rejected[c]);
      if (taken == 0 && last_round) break;
      last_round = finished;
    }
  });

  std::uint64_t views = 0;
  std::uint64_t received_before = 0;
  while (!done.load(std::memory_order_acquire)) {
    for (int c = 0; c < 2; ++c) {
      const Tally tally = link.counters(c).read();
      ASSERT_EQ(tally.received, tally.used + tally.dropped() + tally.queued);
      ASSERT_LE(tally.queued, tally.received) << "never negative";
      if (c == 0) {
        ASSERT_GE(tally.received, received_before);
        received_before = tally.received;
      }
    }
    ++views;
  }
  device.join();
  estimation.join();
  EXPECT_GT(views, 0u);
  for (int c = 0; c < 2; ++c) {
    const Tally tally = link.counters(c).read();
    EXPECT_EQ(tally.received, kScans);
    EXPECT_EQ(tally.queued, 0u) << "nothing is on the way any more";
    EXPECT_EQ(tally.used, used[static_cast<std::size_t>(c)]);
  }
  EXPECT_EQ(link.entered(), link.left());
}

TEST(DeviceLinkThreads, TheLastStateAlwaysArrives) {
  DeviceLink link("amplifier", {0, 1, 2}, 16, nullptr);
  std::atomic<bool> done{false};
  std::thread device([&] {
    for (int i = 0; i < 20'000; ++i)
      link.state(i % 4 - 1, i % 3 == 0 ? DWELL_FAULT_TIMEOUT : DWELL_FAULT_NONE, "flapping");
    link.state(-1, DWELL_FAULT_DISCONNECTED, "unplugged");
    done.store(true, std::memory_order_release);
  });
  std::array<Fault, 3> seen{};
  const auto drain = [&] {
    StateEvent event;
    while (link.pop_event(event))
      for (std::int32_t c = 0; c < 3; ++c)
        if (event.channel < 0 || event.channel == c) seen[static_cast<std::size_t>(c)] = event.fault;
  };
  while (!done.load(std::memory_order_acquire)) drain();
  device.join();
  for (int turn = 0; turn < 3; ++turn) {
    drain();
    link.turn(0);
  }
  for (const Fault fault : seen) EXPECT_EQ(fault, Fault::disconnected);
}

}  // namespace
}  // namespace dwell
