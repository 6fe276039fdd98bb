#include "drivers/modbus/stamp.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace dwell::modbus {
namespace {

TEST(ModbusStamp, IsTheMiddleOfATcpTransaction) {
  const Stamp when = stamp(1000, 3000, 0, 0);
  EXPECT_EQ(when.t_ns, 2000);
  EXPECT_EQ(when.t_half_ns, 1000U);
}

// Eight registers at 19200 baud 8E1: the request takes 4.58 ms, the answer 12.03 ms. The device samples 1 ms after the
// request's end and answers at 2 ms. The middle of the whole transaction would be wrong by 3.7 ms.
TEST(ModbusStamp, TakesTheTimeOnASerialLineOff) {
  const Wire wire{19200.0, 11.0};
  const std::int64_t request_ns = wire.time_ns(8);
  const std::int64_t answer_ns = wire.time_ns(5 + 16);
  EXPECT_NEAR(static_cast<double>(request_ns), 4.583e6, 1e3);
  const std::int64_t sampled_ns = request_ns + 1'000'000;
  const std::int64_t received_ns = request_ns + 2'000'000 + answer_ns;
  const Stamp when = stamp(0, received_ns, request_ns, answer_ns);
  EXPECT_NEAR(static_cast<double>(when.t_ns), static_cast<double>(sampled_ns), 1.0);
  EXPECT_NEAR(static_cast<double>(when.t_half_ns), 1e6, 1.0);
  EXPECT_NEAR(static_cast<double>(received_ns) / 2 - static_cast<double>(sampled_ns), 3.7e6, 0.05e6);
}

TEST(ModbusStamp, StaysWithinATransactionThatIsShorterThanItsWireTime) {
  const Stamp when = stamp(1'000'000, 1'200'000, 700'000, 3'000'000);
  EXPECT_EQ(when.t_ns, 1'100'000);
  EXPECT_EQ(when.t_half_ns, 100'000U);
}

RC_GTEST_PROP(ModbusStamp, CoversEveryInstantAtWhichTheDeviceMayHaveSampled, ()) {
  const std::int64_t sent_ns = *rc::gen::inRange<std::int64_t>(0, 1'000'000'000'000'000);
  const std::int64_t request_ns = *rc::gen::inRange<std::int64_t>(0, 30'000'000);
  const std::int64_t before_ns = *rc::gen::inRange<std::int64_t>(0, 200'000'000);
  const std::int64_t after_ns = *rc::gen::inRange<std::int64_t>(0, 200'000'000);
  const std::int64_t answer_ns = *rc::gen::inRange<std::int64_t>(0, 300'000'000);
  const std::int64_t sampled_ns = sent_ns + request_ns + before_ns;
  const Stamp when = stamp(sent_ns, sampled_ns + after_ns + answer_ns, request_ns, answer_ns);
  RC_ASSERT(std::abs(when.t_ns - sampled_ns) <= std::int64_t{when.t_half_ns});
  RC_ASSERT(std::int64_t{when.t_half_ns} <= (before_ns + after_ns + 1) / 2);
}

RC_GTEST_PROP(ModbusStamp, NeverLeavesTheTransaction, ()) {
  const std::int64_t length_ns = *rc::gen::inRange<std::int64_t>(0, 5'000'000'000);
  const std::int64_t request_ns = *rc::gen::inRange<std::int64_t>(0, 1'000'000'000);
  const std::int64_t answer_ns = *rc::gen::inRange<std::int64_t>(0, 1'000'000'000);
  const Stamp when = stamp(0, length_ns, request_ns, answer_ns);
  RC_ASSERT(when.t_ns >= 0 && when.t_ns <= length_ns);
}

}  // namespace
}  // namespace dwell::modbus
