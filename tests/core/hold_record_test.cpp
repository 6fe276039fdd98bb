#include "core/motion/hold_record.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

HoldRecord::Reading reading_at(std::int64_t t_ns) { return {t_ns, 0.5, 0}; }

void push(HoldRecord& record, std::int64_t from_ns, std::int64_t until_ns) {
  for (std::int64_t t = from_ns; t <= until_ns; ++t) record.push(reading_at(t));
}

TEST(HoldRecord, BeginsWithWhatCameALittleBefore) {
  HoldRecord record(10);
  push(record, 1, 25);
  record.begin(22);
  push(record, 26, 28);
  const auto readings = record.readings();
  ASSERT_EQ(readings.size(), 7u);
  EXPECT_EQ(readings.front().t_ns, 22);
  EXPECT_EQ(readings.back().t_ns, 28);
}

TEST(HoldRecord, LeavesHalfOfTheRoomForTheHoldItself) {
  HoldRecord record(10);
  push(record, 1, 25);
  record.begin(0);
  EXPECT_EQ(record.readings().front().t_ns, 21);
  push(record, 26, 40);
  EXPECT_EQ(record.readings().back().t_ns, 30);
}

TEST(HoldRecord, KeepsTheBeginningWhereThereIsNoMoreRoom) {
  HoldRecord record(10);
  record.begin(0);
  push(record, 1, 25);
  EXPECT_TRUE(record.full());
  EXPECT_EQ(record.readings().front().t_ns, 1);
  EXPECT_EQ(record.readings().back().t_ns, 10);
}

TEST(HoldRecord, SetsNothingFromBeforeAGapBesideWhatComesAfter) {
  HoldRecord record(10);
  record.begin(0);
  push(record, 1, 25);  // 11 to 25 find no room
  record.roll();
  push(record, 26, 28);
  record.begin(5);
  EXPECT_EQ(record.readings().front().t_ns, 26);
}

TEST(HoldRecord, ResumesAHoldWhoseBeginningIsStillThere) {
  HoldRecord record(10);
  record.begin(0);
  push(record, 1, 5);
  record.roll();
  push(record, 6, 8);
  EXPECT_TRUE(record.resume());
  EXPECT_EQ(record.size(), 8u);
  record.roll();
  push(record, 9, 12);
  EXPECT_FALSE(record.resume()) << "1 and 2 are overwritten";
}

TEST(HoldRecord, OfNoReadingsIsEmpty) {
  HoldRecord record(10);
  EXPECT_EQ(record.size(), 0u);
  record.begin(3);
  EXPECT_TRUE(record.readings().empty());
}

}  // namespace
}  // namespace dwell
