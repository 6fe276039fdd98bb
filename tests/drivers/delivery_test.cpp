// What every driver does with readings and failures, in virtual time.
#include "drivers/common/delivery.hpp"

#include <gtest/gtest.h>

#include <array>

#include "drivers/common/backoff.hpp"
#include "tests/drivers/fake_host.hpp"
#include "tests/durations.hpp"

namespace dwell::driver {
namespace {

using test::FakeHost;

// Channels 10 and 11.
class DeliveryTest : public ::testing::Test {
 protected:
  struct Channel {
    std::uint16_t index;
  };
  void deliver(std::size_t channel, std::int64_t t_ns) {
    delivery_.add(channel, {t_ns, 5}, 1.0);
    delivery_.push();
  }
  void fail(std::size_t channel, std::int64_t now_ns) {
    delivery_.fail(channel, DWELL_FAULT_INVALID_VALUE, now_ns, [this] {
      ++reasons_asked_;
      return "no number";
    });
  }
  dwell_fault fault(std::uint16_t channel) const { return host_.state_of(channel).fault; }
  std::uint16_t flags(std::uint16_t channel) const { return host_.samples(channel).back().flags; }

  FakeHost host_;
  Delivery delivery_{Host(*host_.host()), std::array{Channel{10}, Channel{11}}};
  int reasons_asked_ = 0;
};

TEST_F(DeliveryTest, HandsInOneScanAndSaysThatTheChannelsDeliver) {
  delivery_.add(1, {100, 7}, 3.0);
  delivery_.add(0, {101, 8, true}, 4.0);
  EXPECT_EQ(delivery_.size(), 2U);
  EXPECT_TRUE(delivery_.push());
  EXPECT_FALSE(delivery_.push()) << "nothing is left in it";
  EXPECT_EQ(host_.scans(), (std::vector<std::size_t>{2}));
  const auto samples = host_.samples();
  EXPECT_EQ(samples[0].channel, 11);
  EXPECT_EQ(samples[0].t_ns, 100);
  EXPECT_EQ(samples[0].t_half_ns, 7U);
  EXPECT_EQ(samples[0].flags, 0U);
  EXPECT_EQ(samples[1].raw, 4.0);
  EXPECT_EQ(samples[1].flags, DWELL_SAMPLE_STAMP_REPLACED);
  EXPECT_EQ(fault(10), DWELL_FAULT_NONE);
  EXPECT_EQ(fault(11), DWELL_FAULT_NONE);
}

TEST_F(DeliveryTest, TellsAStateWhenItChangesAndNeverTwice) {
  for (int i = 0; i < 3; ++i) delivery_.tell(0, DWELL_FAULT_TIMEOUT, "silent");
  EXPECT_EQ(host_.states_told(), 1U);
  delivery_.tell(0, DWELL_FAULT_TIMEOUT, "silent, and the link is down");
  EXPECT_EQ(host_.states_told(), 2U) << "another reason";
  delivery_.tell(0, DWELL_FAULT_DISCONNECTED, "gone");
  EXPECT_EQ(host_.states_told(), 3U);
  deliver(0, 100);
  deliver(0, 200);
  EXPECT_EQ(host_.states_told(), 4U);
  delivery_.tell(0, DWELL_FAULT_DISCONNECTED, "gone");
  EXPECT_EQ(host_.states_told(), 5U) << "it delivered meanwhile";
}

TEST_F(DeliveryTest, CountsEveryReadingWithoutAValueAndTellsOfTheThird) {
  deliver(0, 100);
  for (int i = 0; i < 2; ++i) fail(0, i * kMs_ns);
  EXPECT_EQ(fault(10), DWELL_FAULT_NONE);
  for (int i = 2; i < 5; ++i) fail(0, i * kMs_ns);
  EXPECT_EQ(fault(10), DWELL_FAULT_INVALID_VALUE);
  EXPECT_EQ(host_.state_of(10).reason, "no number");
  EXPECT_EQ(host_.counted(DWELL_FAULT_INVALID_VALUE), 5);
  EXPECT_EQ(reasons_asked_, 1) << "words are made where they are needed";
  EXPECT_EQ(fault(11), DWELL_FAULT_SILENT);
}

TEST_F(DeliveryTest, AReadingBetweenFailuresBeginsTheirCountAnew) {
  for (int i = 0; i < 20; ++i) {
    fail(0, i * kMs_ns);
    if (i % 2 == 1) deliver(0, i * kMs_ns);
  }
  EXPECT_EQ(fault(10), DWELL_FAULT_NONE);
}

TEST_F(DeliveryTest, MarksTheGapOnTheNextReadingOfTheChannelAlone) {
  delivery_.lost();
  deliver(0, 100);
  EXPECT_EQ(flags(10), 0U) << "nothing can be lost before the first";
  deliver(1, 100);
  delivery_.lost(0);
  deliver(1, 200);
  EXPECT_EQ(flags(11), 0U);
  deliver(0, 200);
  EXPECT_EQ(flags(10), DWELL_SAMPLE_GAP);
  deliver(0, 300);
  EXPECT_EQ(flags(10), 0U);
  fail(0, 0);
  deliver(0, 400);
  EXPECT_EQ(flags(10), DWELL_SAMPLE_GAP) << "a reading without a value is lost";
  delivery_.tell(0, DWELL_FAULT_TIMEOUT, "silent");
  deliver(0, 500);
  EXPECT_EQ(flags(10), DWELL_SAMPLE_GAP) << "so is what a stale channel did not deliver";
}

TEST_F(DeliveryTest, AdvancesAndSaysWhereTheStampDoesNot) {
  for (const std::int64_t t_ns : {100, 100, 50, 102, 200}) deliver(0, t_ns);
  const auto samples = host_.samples(10);
  const std::array<std::int64_t, 5> expected{100, 101, 102, 103, 200};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(samples[i].t_ns, expected[i]);
    EXPECT_EQ(samples[i].flags, i > 0 && i < 4 ? DWELL_SAMPLE_STAMP_REPLACED : 0U) << i;
  }
}

TEST_F(DeliveryTest, HoldsAllChannelsForTheLastReasonUntilEachDelivers) {
  EXPECT_TRUE(delivery_.held()) << "nothing is there yet";
  delivery_.release();
  deliver(0, 100);
  delivery_.hold(DWELL_FAULT_DISCONNECTED, "the link is down");
  delivery_.hold(DWELL_FAULT_DISCONNECTED, "the interface was removed");
  delivery_.hold(DWELL_FAULT_DISCONNECTED, "the interface was removed");
  EXPECT_EQ(host_.states_told(), 1U + 2U * 2U);
  EXPECT_EQ(host_.state_of(11).reason, "the interface was removed");
  EXPECT_TRUE(delivery_.held());
  delivery_.release();
  EXPECT_FALSE(delivery_.held());
  EXPECT_EQ(fault(10), DWELL_FAULT_DISCONNECTED) << "it has not delivered yet";
  deliver(0, 200);
  EXPECT_EQ(fault(10), DWELL_FAULT_NONE);
  EXPECT_EQ(flags(10), DWELL_SAMPLE_GAP);
  EXPECT_EQ(fault(11), DWELL_FAULT_DISCONNECTED);
}

TEST_F(DeliveryTest, CountsLossesInNumbersAndWritesALineASecond) {
  deliver(0, 100);
  delivery_.overflow(0, "can0", 0);
  EXPECT_TRUE(host_.logged().empty());
  delivery_.overflow(5, "can0", kSecond_ns);
  for (int i = 1; i < 100; ++i) delivery_.overflow(1'000'000, "can0", kSecond_ns + i * kMs_ns);
  EXPECT_EQ(host_.counted(DWELL_FAULT_OVERFLOW), 99'000'005);
  delivery_.overflow(1, "can0", 2 * kSecond_ns);
  EXPECT_EQ(host_.logged(), (std::vector<std::string>{"can0: 5 frames were lost for lack of room",
                                                      "can0: 99000001 frames were lost for lack of room"}));
  deliver(0, 200);
  EXPECT_EQ(flags(10), DWELL_SAMPLE_GAP);
}

TEST_F(DeliveryTest, AllocatesNothingForAReading) {
  deliver(0, 1);
  deliver(1, 1);
  const std::size_t before = test::allocations_of_this_thread();
  for (int i = 2; i < 1000; ++i) {
    delivery_.add(0, {i, 0}, 1.0);
    delivery_.add(1, {i, 0}, 1.0);
    delivery_.push();
    delivery_.lost();
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(FailureRun, IsAStateFromTheThirdOnOrAfterASecond) {
  FailureRun often;
  EXPECT_FALSE(often.add(0));
  EXPECT_FALSE(often.add(1));
  EXPECT_TRUE(often.add(2));
  EXPECT_TRUE(often.add(3));
  FailureRun seldom;
  EXPECT_FALSE(seldom.add(5 * kSecond_ns));
  EXPECT_TRUE(seldom.add(6 * kSecond_ns));
  seldom.end();
  EXPECT_FALSE(seldom.add(9 * kSecond_ns));
}

TEST(Backoff, DoublesFromATenthOfASecondToItsLongestAndBeginsAnew) {
  Backoff backoff(300 * kMs_ns);
  EXPECT_EQ(backoff.next_ns(), 100 * kMs_ns);
  EXPECT_EQ(backoff.next_ns(), 200 * kMs_ns);
  EXPECT_EQ(backoff.next_ns(), 300 * kMs_ns);
  EXPECT_EQ(backoff.next_ns(), 300 * kMs_ns);
  backoff.reset();
  EXPECT_EQ(backoff.next_ns(), 100 * kMs_ns);
}

}  // namespace
}  // namespace dwell::driver
