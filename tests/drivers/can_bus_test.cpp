// What a bus makes of what its socket says.
#include <gtest/gtest.h>

#include "drivers/socketcan/bus.hpp"
#include "tests/drivers/can_fake_socket.hpp"
#include "tests/durations.hpp"

namespace dwell::socketcan {
namespace {

using test::FakeBus;

// The clocks as the test sets them.
std::int64_t the_raw_ns = 0, the_wall_less_raw_ns = 0;
ClockPair the_clocks() noexcept { return {the_raw_ns, the_raw_ns + the_wall_less_raw_ns, 100}; }

class CanBus : public ::testing::Test {
 protected:
  CanBus() : bus_("can0", fake_.opener(), &the_clocks) {
    the_raw_ns = 1000 * kMs_ns;
    the_wall_less_raw_ns = 500 * kHour_ns;
    EXPECT_EQ(bus_.open(), "");
  }
  void arrive_at(std::int64_t raw_ns) {
    Packet packet;
    packet.frame.can_id = 1;
    packet.size = CAN_MTU;
    packet.real_ns = raw_ns + the_wall_less_raw_ns;
    fake_.arrive(packet);
  }
  FakeBus fake_;
  Bus bus_;
};

TEST_F(CanBus, KeepsInstantsWhenTheWallClockIsSetBetweenStampAndReading) {
  for (const std::int64_t step : {kHour_ns, -kHour_ns, 5 * kHour_ns}) {
    bus_.read();
    const std::int64_t came_ns = the_raw_ns + 3 * kMs_ns;
    arrive_at(came_ns);
    the_wall_less_raw_ns += step;
    the_raw_ns += 10 * kMs_ns;
    const Receipt receipt = bus_.read();
    ASSERT_EQ(receipt.frames.size(), 1U);
    EXPECT_FALSE(receipt.frames[0].stamp.replaced);
    EXPECT_NEAR(static_cast<double>(receipt.frames[0].stamp.t_ns), static_cast<double>(came_ns), 1000.0);
  }
}

// More frames than one batch holds, all older than the reads between which they are taken.
TEST_F(CanBus, KnowsThatWhatWaitsBehindAFullBatchIsOlderThanTheLastRead) {
  bus_.read();
  const std::int64_t first_ns = the_raw_ns + kMs_ns;
  for (std::size_t i = 0; i < 2 * Bus::kBatch; ++i) arrive_at(first_ns + static_cast<std::int64_t>(i));
  the_raw_ns += 500 * kMs_ns;
  EXPECT_TRUE(bus_.read().more);
  the_raw_ns += 100 * kMs_ns;
  const Receipt second = bus_.read();
  ASSERT_EQ(second.frames.size(), Bus::kBatch);
  for (const Frame& frame : second.frames) {
    EXPECT_FALSE(frame.stamp.replaced);
    EXPECT_LT(frame.stamp.t_ns, first_ns + kMs_ns);
  }
}

TEST_F(CanBus, ReplacesAStampBeforeTheLastRead) {
  bus_.read();
  arrive_at(the_raw_ns - 100 * kMs_ns);
  the_raw_ns += 10 * kMs_ns;
  const Receipt receipt = bus_.read();
  EXPECT_TRUE(receipt.frames[0].stamp.replaced);
  EXPECT_EQ(receipt.frames[0].stamp.t_ns, the_raw_ns);
}

TEST_F(CanBus, CountsWhatTheKernelDroppedOnce) {
  fake_.drop(7);
  arrive_at(the_raw_ns);
  EXPECT_EQ(bus_.read().lost, 7U);
  EXPECT_EQ(bus_.read().lost, 0U);
  fake_.drop(UINT32_MAX);  // the kernel's counter wraps
  EXPECT_EQ(bus_.read().lost, UINT32_MAX);
}

TEST_F(CanBus, HearsTheControllersState) {
  const auto say = [&](canid_t what, std::uint8_t state) {
    fake_.arrive(CAN_ERR_FLAG | what, {0, state, 0, 0, 0, 0, 0, 0});
    return bus_.read();
  };
  EXPECT_EQ(bus_.controller(), Controller::active);
  EXPECT_EQ(say(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_WARNING).errors, 1U);
  EXPECT_EQ(bus_.controller(), Controller::warning);
  say(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE);
  EXPECT_EQ(bus_.controller(), Controller::passive);
  EXPECT_TRUE(say(CAN_ERR_BUSOFF, 0).bus_off);
  EXPECT_EQ(bus_.controller(), Controller::bus_off);
  EXPECT_TRUE(say(CAN_ERR_RESTARTED, 0).restarted);
  EXPECT_EQ(bus_.controller(), Controller::active);
  EXPECT_EQ(say(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW).lost, 1U) << "lost in the controller";
}

TEST_F(CanBus, TakesAFrameForASignThatTheControllerIsBack) {
  fake_.arrive(CAN_ERR_FLAG | CAN_ERR_BUSOFF, {0, 0, 0, 0, 0, 0, 0, 0});
  bus_.read();
  arrive_at(the_raw_ns);
  bus_.read();
  EXPECT_EQ(bus_.controller(), Controller::active);
}

TEST_F(CanBus, CountsWhatIsNoFrame) {
  Packet packet;
  packet.size = 5;
  fake_.arrive(packet);
  packet.size = CAN_MTU;
  packet.frame.len = 9;
  fake_.arrive(packet);
  packet.size = CANFD_MTU;
  packet.frame.len = 65;
  fake_.arrive(packet);
  const Receipt receipt = bus_.read();
  EXPECT_EQ(receipt.malformed, 3U);
  EXPECT_TRUE(receipt.frames.empty());
}

TEST_F(CanBus, TakesTheOtherEndsLeavingForAnError) {
  Packet packet;
  fake_.arrive(packet);
  EXPECT_EQ(bus_.read().error, ECONNRESET);
}

TEST_F(CanBus, UsesTheInterfacesOwnStampsUnlessToldOtherwise) {
  const auto run = [&] {
    std::int64_t worst_ns = 0;
    for (int i = 0; i < 100; ++i) {
      the_raw_ns += 10 * kMs_ns;
      Packet packet;
      packet.size = CAN_MTU;
      packet.hardware_ns = the_raw_ns - 4 * kMs_ns;  // a clock of its own, regular
      packet.real_ns = the_raw_ns - (i % 3 == 0 ? 2 : 1) * kMs_ns + the_wall_less_raw_ns;
      fake_.arrive(packet);
      const Receipt receipt = bus_.read();
      if (i > 5) worst_ns = std::max(worst_ns, std::abs(receipt.frames[0].stamp.t_ns - (the_raw_ns - 2 * kMs_ns)));
    }
    return worst_ns;
  };
  EXPECT_LE(run(), 1000);
  EXPECT_TRUE(bus_.hardware_stamps());
  bus_.use_hardware_stamps(false);
  ASSERT_EQ(bus_.open(), "");
  EXPECT_GE(run(), kMs_ns - 1000);
  EXPECT_FALSE(bus_.hardware_stamps());
}

TEST(CanSocket, SaysWhyAnInterfaceCannotBeOpened) {
  EXPECT_NE(open_socket("unix:/nonexistent/bus", {}).error().find("No such file"), std::string::npos);
  EXPECT_FALSE(open_socket("nocan7", {}).error().empty());
  EXPECT_EQ(interface_fault("can0"), "");
  EXPECT_NE(interface_fault("a-name-that-is-far-too-long"), "");
  EXPECT_NE(interface_fault(""), "");
  EXPECT_NE(interface_fault("unix:"), "");
  EXPECT_NE(interface_fault("unix:" + std::string(200, 'x')), "");
}

}  // namespace
}  // namespace dwell::socketcan
