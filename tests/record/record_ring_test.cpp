#include "daemon/record/record_ring.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

namespace dwell::record {
namespace {

struct Drained {
  std::vector<std::int64_t> order;  // t_ns of records; -position of results; -1000000 - count of gaps
  void from(RecordRing& ring) {
    ring.drain({[this](const Record& r) { order.push_back(r.t_ns); },
                [this](const RingResult& r) { order.push_back(-static_cast<std::int64_t>(r.position)); },
                [this](std::uint64_t lost) { order.push_back(-1'000'000 - static_cast<std::int64_t>(lost)); }});
  }
};

Record at(std::int64_t t_ns) { return {.t_ns = t_ns}; }

TEST(RecordRing, HoldsFiveSecondsOfTheRigWithinItsBounds) {
  EXPECT_GE(ring_records(640'000.0), 5 * 640'000u);
  EXPECT_EQ(ring_records(0.0), 1u << 16);
  EXPECT_EQ(ring_records(1e12), 1u << 23);
  EXPECT_EQ(ring_records(std::numeric_limits<double>::quiet_NaN()), 1u << 23);
}

TEST(RecordRing, ADiskThatStallsForFiveSecondsLosesNoRecord) {
  constexpr double kRate_hz = 64'000.0;
  RecordRing ring(ring_records(kRate_hz));
  const auto stalled = static_cast<std::int64_t>(5.0 * (kRate_hz + 100.0));
  for (std::int64_t i = 1; i <= stalled; ++i) ring.push(at(i));
  Drained drained;
  drained.from(ring);
  EXPECT_EQ(ring.lost_records(), 0u);
  ASSERT_EQ(drained.order.size(), static_cast<std::size_t>(stalled));
  EXPECT_EQ(drained.order.back(), stalled);
}

TEST(RecordRing, AResultComesWhereItWasPublished) {
  RecordRing ring(100);
  const auto dwell = std::make_shared<const Dwell>();
  ring.push(at(1));
  ring.push(at(2));
  ring.push(2, false, dwell);
  ring.push(at(3));
  ring.push(3, false, dwell);
  ring.push(3, true, dwell);
  Drained drained;
  drained.from(ring);
  EXPECT_EQ(drained.order, (std::vector<std::int64_t>{1, 2, -2, 3, -3, -3}));
}

TEST(RecordRing, AFullRingLeavesOneGapWithItsCountUntilHalfOfItIsFree) {
  RecordRing ring(10);
  for (int i = 1; i <= 15; ++i) ring.push(at(i));
  ring.push(15, false, std::make_shared<const Dwell>());
  EXPECT_EQ(ring.lost_records(), 5u);
  EXPECT_EQ(ring.lost_results(), 1u) << "published in the gap";
  EXPECT_EQ(ring.fill(), 1.0);
  Drained drained;
  drained.from(ring);
  ring.push(at(16));
  drained.from(ring);
  EXPECT_EQ(drained.order, (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, -1'000'005, 16}));
}

TEST(RecordRing, BetweenTwoThreadsRecordsAndResultsKeepTheirOrder) {
  constexpr std::int64_t kCount = 300'000;
  RecordRing ring(kCount);
  std::thread producer([&] {
    const auto dwell = std::make_shared<const Dwell>();
    for (std::int64_t i = 1; i <= kCount; ++i) {
      ring.push(at(i));
      if (i % 5000 == 0) ring.push(static_cast<std::uint64_t>(i), false, dwell);
    }
  });
  std::int64_t newest = 0, misplaced = 0, results = 0;
  while (newest < kCount || results < kCount / 5000) {
    ring.drain({[&](const Record& r) { misplaced += r.t_ns == ++newest ? 0 : 1; },
                [&](const RingResult& r) {
                  ++results;
                  misplaced += static_cast<std::int64_t>(r.position) == newest ? 0 : 1;
                },
                [&](std::uint64_t) { ++misplaced; }});
  }
  producer.join();
  EXPECT_EQ(misplaced, 0);
}

}  // namespace
}  // namespace dwell::record
