#include "core/stream/merger.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace dwell {
namespace {

Record at(std::int64_t t_ns, std::uint16_t channel = 0) {
  Record record;
  record.t_ns = t_ns;
  record.channel = channel;
  return record;
}

TEST(Merger, ReleasesInOrderOfInstantThenSourceThenArrival) {
  Merger merger(3, 1000, 100);
  merger.push(2, at(10, 20));
  merger.push(1, at(10, 10));
  merger.push(1, at(10, 11));
  merger.push(0, at(5, 0));
  std::vector<int> order;
  for (Record out; merger.flush(out);) order.push_back(out.channel);
  EXPECT_EQ(order, (std::vector<int>{0, 10, 11, 20}));
}

TEST(Merger, WaitsForTheSlowestLiveSource) {
  Merger merger(2, 1000, 100);
  Record out;
  merger.push(0, at(10));
  merger.push(1, at(8));
  merger.push(0, at(20));
  // Source 1 has shown 8 and may still bring another 8: nothing at or beyond it is released.
  EXPECT_FALSE(merger.pop(out));
  merger.push(1, at(15));
  ASSERT_TRUE(merger.pop(out));
  EXPECT_EQ(out.t_ns, 8);
  ASSERT_TRUE(merger.pop(out));
  EXPECT_EQ(out.t_ns, 10);
  EXPECT_FALSE(merger.pop(out));
}

TEST(Merger, DoesNotWaitForASourceThatIsNotLiveNorLongerThanTheHoldBack) {
  Merger merger(2, 100, 100);
  Record out;
  merger.push(1, at(0));
  merger.push(0, at(50));
  EXPECT_FALSE(merger.pop(out));
  merger.set_live(1, false);
  merger.push(0, at(60));
  ASSERT_TRUE(merger.pop(out));
  EXPECT_EQ(out.t_ns, 0);
  ASSERT_TRUE(merger.pop(out));
  EXPECT_EQ(out.t_ns, 50);

  Merger slow(2, 100, 100);
  slow.push(1, at(0));
  slow.push(0, at(50));
  slow.push(0, at(151));
  ASSERT_TRUE(slow.pop(out));
  ASSERT_TRUE(slow.pop(out));  // 50 < 151 - 100
  EXPECT_EQ(out.t_ns, 50);
  EXPECT_EQ(slow.push(1, at(49)), Merger::Admission::late);
  EXPECT_EQ(slow.push(1, at(50)), Merger::Admission::queued);
}

TEST(Merger, OneStampFarInTheFutureMakesNoOtherSourceLate) {
  Merger merger(3, 100, 100);
  Record out;
  merger.set_now(1000);
  merger.push(0, at(1'000'000'000));
  merger.push(1, at(990));
  merger.push(2, at(1000));
  while (merger.pop(out)) EXPECT_LT(out.t_ns, 1000);
  EXPECT_EQ(merger.push(1, at(995)), Merger::Admission::queued);
  // It comes out when its time has come.
  merger.set_now(1'000'000'200);
  for (std::size_t source = 0; source < 3; ++source) merger.push(source, at(1'000'000'200));
  while (merger.pop(out)) {
  }
  EXPECT_EQ(out.t_ns, 1'000'000'000);
}

TEST(Merger, ASourceThatMayLeadIsNotHeldBack) {
  Merger merger(2, 100, 100);
  Record out;
  merger.set_leading(0);
  merger.set_now(1000);
  merger.push(1, at(1000));
  merger.push(0, at(5000));
  merger.push(0, at(6000));
  ASSERT_TRUE(merger.pop(out));
  ASSERT_TRUE(merger.pop(out));
  EXPECT_EQ(out.t_ns, 5000);
}

TEST(Merger, RefusesWhatItHasNoRoomFor) {
  Merger merger(1, 100, 2);
  EXPECT_EQ(merger.push(0, at(1)), Merger::Admission::queued);
  EXPECT_EQ(merger.push(0, at(2)), Merger::Admission::queued);
  EXPECT_EQ(merger.push(0, at(3)), Merger::Admission::full);
  EXPECT_EQ(merger.size(), 2u);
}

TEST(Merger, WhateverArrivesComesOutOnceInOrderOrIsCountedAsDropped) {
  std::mt19937_64 rng(4);
  for (int trial = 0; trial < 300; ++trial) {
    const std::size_t sources = 1 + rng() % 5;
    Merger merger(sources, 50, 64);
    std::vector<std::int64_t> clock(sources, 0);
    std::uint64_t pushed = 0, dropped = 0, out_count = 0;
    std::int64_t last = INT64_MIN;
    const auto drain = [&](bool all) {
      Record out;
      while (all ? merger.flush(out) : merger.pop(out)) {
        ASSERT_GE(out.t_ns, last);
        last = out.t_ns;
        ++out_count;
      }
    };
    for (int i = 0; i < 500; ++i) {
      const std::size_t source = rng() % sources;
      clock[source] += static_cast<std::int64_t>(rng() % 20) - 2;  // hardware stamps may step back a little
      ++pushed;
      if (merger.push(source, at(clock[source])) != Merger::Admission::queued) ++dropped;
      if (rng() % 50 == 0) merger.set_live(source, false);
      if (rng() % 3 == 0) drain(false);
      ASSERT_EQ(pushed, dropped + out_count + merger.size());
    }
    drain(true);
    EXPECT_EQ(pushed, dropped + out_count);
  }
}

}  // namespace
}  // namespace dwell
