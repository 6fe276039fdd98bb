// What befalls the bus itself, held against the master's thread over a scripted socket: named, counted, and every node
// set up again when it is over.
#include <gtest/gtest.h>

#include <optional>
#include <thread>

#include "drivers/canopen/master.hpp"
#include "drivers/canopen/outbox.hpp"
#include "tests/drivers/can_fake_socket.hpp"
#include "tests/drivers/fake_host.hpp"

namespace dwell::canopen {
namespace {

using test::eventually;
using test::FakeBus;
using test::FakeHost;

// Node 7, channel 10; nobody answers unless the test does.
class CanopenFault : public ::testing::Test {
 protected:
  CanopenFault() {
    setup_.interface = "can0";
    Wish wish;
    wish.node = 7;
    wish.wanted.push_back({{0x9130, 1}, {Kind::signed_integer, 32}, 0});
    setup_.nodes.push_back(wish);
    setup_.channels.push_back({10, "node 7, 9130h:01", 0});
  }
  ~CanopenFault() override {
    stop_.request();
    if (thread_.joinable()) thread_.join();
  }
  void start() {
    master_.emplace(setup_, driver::Host(*host_.host()), bus_.opener());
    thread_ = std::thread([this] { master_->run(stop_); });
  }
  // How often node 7 was told to reset its communication.
  int resets() const {
    int count = 0;
    for (const canfd_frame& frame : bus_.written())
      count += frame.can_id == kNmt && frame.len == 2 && frame.data[0] == 0x82 && frame.data[1] == 7 ? 1 : 0;
    return count;
  }
  bool is_stale(dwell_fault why) const { return host_.state_of(10).fault == why; }
  std::string reason() const { return host_.state_of(10).reason; }
  void send_error(canid_t what) { bus_.arrive(CAN_ERR_FLAG | what, std::vector<std::uint8_t>(8, 0)); }

  canopen::Setup setup_;
  FakeBus bus_;
  FakeHost host_;
  driver::Stop stop_{nullptr};
  std::int64_t begin_ns_ = driver::monotonic_ns();
  std::optional<Master> master_;
  std::thread thread_;
};

TEST_F(CanopenFault, IsBusOffUntilTheControllerIsRestarted) {
  start();
  ASSERT_TRUE(eventually([&] { return resets() == 1; }));
  send_error(CAN_ERR_BUSOFF);
  ASSERT_TRUE(eventually([&] { return is_stale(DWELL_FAULT_BUS_OFF); }));
  EXPECT_EQ(reason(), "can0: bus-off; it must be restarted, or have restart-ms set");
  EXPECT_EQ(host_.counted(DWELL_FAULT_BUS_OFF), 1);
  const int before = resets();
  send_error(CAN_ERR_RESTARTED);
  EXPECT_TRUE(eventually([&] { return resets() > before; }));
}

TEST_F(CanopenFault, SetsNodesUpAgainOnceALinkIsUpThoughNothingIsSentThere) {
  start();
  ASSERT_TRUE(eventually([&] { return resets() == 1; }));
  bus_.set_link(socketcan::Link::down);
  bus_.refuse_writes(ENETDOWN);
  bus_.fail(ENETDOWN);
  ASSERT_TRUE(eventually([&] { return is_stale(DWELL_FAULT_DISCONNECTED); }));
  EXPECT_EQ(reason(), "can0: the link is down");
  bus_.set_link(socketcan::Link::up);
  const int told = host_.counted(DWELL_FAULT_DISCONNECTED);
  EXPECT_TRUE(eventually([&] { return host_.counted(DWELL_FAULT_DISCONNECTED) > told; }));  // tried, in vain
  bus_.refuse_writes(0);
  EXPECT_TRUE(eventually([&] { return resets() > 1; }));
  EXPECT_EQ(bus_.opened(), 1);
}

TEST_F(CanopenFault, IsBusOffWhereTheInterfaceHasNoCarrier) {
  bus_.set_link(socketcan::Link::no_carrier);
  start();
  ASSERT_TRUE(eventually([&] { return is_stale(DWELL_FAULT_BUS_OFF); }));
  EXPECT_EQ(reason(), "can0: the interface has no carrier: bus-off, unless restarted");
  const int before = resets();
  bus_.set_link(socketcan::Link::up);
  EXPECT_TRUE(eventually([&] { return resets() > before; }));
}

TEST_F(CanopenFault, SaysThatTheInterfaceWasRemovedThoughItsLinkWasDownBefore) {
  start();
  ASSERT_TRUE(eventually([&] { return resets() == 1; }));
  bus_.set_link(socketcan::Link::down);
  bus_.fail(ENETDOWN);
  ASSERT_TRUE(eventually([&] { return reason() == "can0: the link is down"; }));
  bus_.refuse("can0: there is no such interface");
  bus_.fail(ENODEV);
  EXPECT_TRUE(eventually([&] { return reason() == "can0: there is no such interface"; }));
}

TEST_F(CanopenFault, PausesBetweenAttemptsAtASocketThatFailsAtOnce) {
  bus_.fail_always(ENODEV);
  start();
  ASSERT_TRUE(eventually([&] { return bus_.opened() >= 3; }));
  EXPECT_GE(driver::monotonic_ns() - begin_ns_, 250'000'000);
}

TEST_F(CanopenFault, OpensAnInterfaceAnewThatWasRemoved) {
  start();
  ASSERT_TRUE(eventually([&] { return resets() == 1; }));
  bus_.refuse("can0: there is no such interface");
  bus_.fail(ENODEV);
  ASSERT_TRUE(eventually([&] { return is_stale(DWELL_FAULT_DISCONNECTED) && bus_.opened() > 2; }));
  bus_.refuse("");
  EXPECT_TRUE(eventually([&] { return resets() > 1; }));
}

TEST_F(CanopenFault, KeepsWhatFindsNoRoomForLater) {
  bus_.refuse_writes(ENOBUFS);
  start();
  ASSERT_TRUE(eventually([&] { return host_.turns() > 0 || bus_.opened() == 1; }));
  EXPECT_EQ(resets(), 0);
  bus_.refuse_writes(0);
  EXPECT_TRUE(eventually([&] { return resets() == 1; }));
  EXPECT_EQ(host_.counted(DWELL_FAULT_DISCONNECTED), 0);
}

TEST_F(CanopenFault, CountsWhatTheKernelDroppedAndWhatIsNoFrame) {
  start();
  ASSERT_TRUE(eventually([&] { return resets() == 1; }));
  socketcan::Packet packet;
  packet.size = 3;
  bus_.drop(5);
  bus_.arrive(packet);
  ASSERT_TRUE(eventually([&] { return host_.counted(DWELL_FAULT_BAD_FRAME) == 1; }));
  EXPECT_EQ(host_.counted(DWELL_FAULT_OVERFLOW), 5);
  EXPECT_EQ(host_.logged().front(), "can0: 5 frames were lost for lack of room");
}

// A node that boots again and again is given two frames each time, and none of them can be sent.
TEST_F(CanopenFault, CountsWhatItCouldNotKeepForLater) {
  constexpr int kBoots = 400, kRoom = Outbox::kRoom;
  bus_.refuse_writes(ENOBUFS);
  start();
  ASSERT_TRUE(eventually([&] { return bus_.is_open(); }));
  for (int i = 0; i < kBoots; ++i) bus_.arrive(kHeartbeat + 7, {0});
  EXPECT_TRUE(eventually([&] { return host_.counted(DWELL_FAULT_OVERFLOW) >= 2 * kBoots - kRoom; }));
}

// Nodes are silent, and frames of no meaning come faster than they can be read.
TEST_F(CanopenFault, SeesThatANodeIsSilentOnABusThatNeverCeases) {
  start();
  bus_.babble(true);
  EXPECT_TRUE(eventually([&] { return is_stale(DWELL_FAULT_TIMEOUT); }));
  EXPECT_EQ(reason(), "node 7: no answer when asked for 1000h:00");
  bus_.babble(false);
}

}  // namespace
}  // namespace dwell::canopen
