// Everything that a bus does to a driver: each is counted by its kind, named, and over when it is over.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "drivers/can/reader.hpp"
#include "tests/drivers/can_fake_socket.hpp"
#include "tests/drivers/fake_host.hpp"

namespace dwell::can {
namespace {

using test::eventually;
using test::FakeBus;
using test::FakeHost;

// Channel 10: the first byte of message 1. Channel 11: bytes 1 to 4 of it, a float. Channel 12: message 2.
class CanFault : public ::testing::Test {
 protected:
  CanFault() {
    setup_.interface = "can0";
    const auto add = [&](std::uint16_t index, const char* source, canid_t id, const Field& field) {
      setup_.channels.push_back({index, source, timeout_ns_});
      setup_.wanted.push_back({{id, false, false, -1}, field, 1.0, 0.0, {}});
    };
    add(10, "One.Byte", 1, {0, 8});
    add(11, "One.Float", 1, {8, 32, Order::intel, Form::float32});
    add(12, "Two.Byte", 2, {0, 8});
  }
  ~CanFault() override { stop(); }
  void start() {
    reader_.emplace(setup_, driver::Host(*host_.host()), bus_.opener());
    thread_ = std::thread([this] { reader_->run(stop_); });
  }
  void stop() {
    stop_.request();
    if (thread_.joinable()) thread_.join();
  }
  void send(std::uint8_t value = 1) { bus_.arrive(1, {value, 0, 0, 0x80, 0x3F, 0, 0, 0}); }
  void send_both() {
    send();
    bus_.arrive(2, {1});
  }
  bool delivers(std::uint16_t channel) { return host_.state_of(channel).fault == DWELL_FAULT_NONE; }
  bool is_stale(std::uint16_t channel, dwell_fault why) { return host_.state_of(channel).fault == why; }

  std::int64_t timeout_ns_ = 60'000'000'000;
  can::Setup setup_;
  FakeBus bus_;
  FakeHost host_;
  driver::Stop stop_{nullptr};
  std::optional<Reader> reader_;
  std::thread thread_;
};

TEST_F(CanFault, PushesTheSignalsOfAFrameAsOneScanOfOneInstant) {
  start();
  send(7);
  ASSERT_TRUE(eventually([&] { return host_.sample_count() == 2; }));
  EXPECT_EQ(host_.scans(), (std::vector<std::size_t>{2}));
  EXPECT_EQ(host_.samples()[0].raw, 7.0);
  EXPECT_EQ(host_.samples()[1].raw, 1.0);
  EXPECT_EQ(host_.samples()[0].t_ns, host_.samples()[1].t_ns);
}

// Where the machine holds up the reading of the clocks, a stamp does not fit and is replaced. That is not so of every
// frame.
TEST_F(CanFault, TakesTheStampOfTheKernel) {
  start();
  std::size_t sent = 0;
  ASSERT_TRUE(eventually([&] {
    send();
    sent += 2;
    return eventually([&] { return host_.sample_count() >= sent; }) && host_.samples().back().flags == 0U;
  }));
}

TEST_F(CanFault, CountsWhatTheKernelDroppedAndMarksTheGap) {
  start();
  send_both();
  ASSERT_TRUE(eventually([&] { return host_.sample_count() == 3; }));
  bus_.drop(5);
  send();
  send();
  bus_.arrive(2, {1});
  ASSERT_TRUE(eventually([&] { return host_.sample_count() == 8; }));
  EXPECT_EQ(host_.counted(DWELL_FAULT_OVERFLOW), 5);
  EXPECT_EQ(host_.samples(10)[1].flags & DWELL_SAMPLE_GAP, DWELL_SAMPLE_GAP);
  EXPECT_EQ(host_.samples(10)[2].flags & DWELL_SAMPLE_GAP, 0U);
  EXPECT_EQ(host_.samples(12)[1].flags & DWELL_SAMPLE_GAP, DWELL_SAMPLE_GAP);
  ASSERT_EQ(host_.logged().size(), 1U);
  EXPECT_EQ(host_.logged()[0], "can0: 5 frames were lost for lack of room");
}

TEST_F(CanFault, IsBusOffUntilFramesComeAgain) {
  start();
  send_both();
  ASSERT_TRUE(eventually([&] { return delivers(10) && delivers(12); }));
  bus_.arrive(CAN_ERR_FLAG | CAN_ERR_BUSOFF, {0, 0, 0, 0, 0, 0, 0, 0});
  ASSERT_TRUE(eventually([&] { return is_stale(10, DWELL_FAULT_BUS_OFF) && is_stale(12, DWELL_FAULT_BUS_OFF); }));
  EXPECT_EQ(host_.counted(DWELL_FAULT_BUS_OFF), 1);
  EXPECT_EQ(host_.state_of(10).reason, "can0: bus-off; it must be restarted, or have restart-ms set");
  bus_.arrive(CAN_ERR_FLAG | CAN_ERR_RESTARTED, {0, 0, 0, 0, 0, 0, 0, 0});
  send();
  ASSERT_TRUE(eventually([&] { return delivers(10); }));
  EXPECT_EQ(host_.counted(DWELL_FAULT_BUS_ERROR), 0) << "a restart is no error";
  EXPECT_TRUE(is_stale(12, DWELL_FAULT_BUS_OFF)) << "its own frame has not come yet";
  EXPECT_EQ(host_.samples(10).back().flags & DWELL_SAMPLE_GAP, DWELL_SAMPLE_GAP);
  EXPECT_EQ(bus_.opened(), 1);
}

TEST_F(CanFault, NamesErrorPassiveOnceAndGoesOn) {
  start();
  for (int i = 0; i < 50; ++i) bus_.arrive(CAN_ERR_FLAG | CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_PASSIVE, 0, 0, 0, 0, 0, 0});
  send_both();
  ASSERT_TRUE(eventually([&] { return delivers(10) && host_.counted(DWELL_FAULT_BUS_ERROR) == 50; }));
  ASSERT_TRUE(eventually([&] { return host_.logged().size() == 1; }));
  EXPECT_EQ(host_.logged()[0], "can0: the controller is error-passive");
}

TEST_F(CanFault, IsBackWithTheNextFrameAfterTheLinkWasDown) {
  start();
  send_both();
  ASSERT_TRUE(eventually([&] { return delivers(12); }));
  bus_.fail(ENETDOWN);
  ASSERT_TRUE(
      eventually([&] { return is_stale(10, DWELL_FAULT_DISCONNECTED) && is_stale(12, DWELL_FAULT_DISCONNECTED); }));
  EXPECT_EQ(host_.state_of(10).reason, "can0: the link is down");
  EXPECT_TRUE(eventually([&] { return host_.counted(DWELL_FAULT_DISCONNECTED) >= 1; }));
  send_both();
  ASSERT_TRUE(eventually([&] { return delivers(10) && delivers(12); }));
  EXPECT_EQ(bus_.opened(), 1) << "the same socket";
}

TEST_F(CanFault, NamesTheLastReasonOfALinkThatGoesDownAsItsInterfaceIsRemoved) {
  start();
  send_both();
  ASSERT_TRUE(eventually([&] { return delivers(12); }));
  bus_.fail(ENETDOWN);
  ASSERT_TRUE(eventually([&] { return host_.state_of(12).reason == "can0: the link is down"; }));
  bus_.refuse("can0: there is no such interface");
  bus_.fail(ENODEV);
  ASSERT_TRUE(eventually([&] { return host_.state_of(12).reason == "can0: there is no such interface"; }));
}

TEST_F(CanFault, NoLongerBlamesALinkThatIsUpForFramesThatStayAway) {
  for (Channel& channel : setup_.channels) channel.timeout_ns = 200'000'000;
  start();
  send_both();
  ASSERT_TRUE(eventually([&] { return delivers(12); }));
  bus_.set_link(socketcan::Link::down);
  bus_.fail(ENETDOWN);
  ASSERT_TRUE(eventually([&] { return is_stale(10, DWELL_FAULT_DISCONNECTED); }));
  bus_.set_link(socketcan::Link::up);
  ASSERT_TRUE(eventually([&] { return is_stale(10, DWELL_FAULT_TIMEOUT) && is_stale(12, DWELL_FAULT_TIMEOUT); }));
  EXPECT_EQ(host_.state_of(12).reason, "Two.Byte: no frame for 0.2 s");
  EXPECT_EQ(host_.logged().back(), "can0: the link is up again");
}

// A service that is started while the controller is off the bus hears no error frame of it.
TEST_F(CanFault, NamesTheMissingCarrierWhereFramesStayAway) {
  for (Channel& channel : setup_.channels) channel.timeout_ns = 50'000'000;
  bus_.set_link(socketcan::Link::no_carrier);
  start();
  ASSERT_TRUE(eventually([&] { return is_stale(12, DWELL_FAULT_TIMEOUT); }));
  EXPECT_EQ(host_.state_of(12).reason,
            "Two.Byte: no frame for 0.05 s; the interface has no carrier: bus-off, unless restarted");
}

TEST_F(CanFault, PausesBeforeASocketThatFailsAtOnceIsOpenedAgain) {
  bus_.fail_always(EIO);
  const std::int64_t begin_ns = driver::monotonic_ns();
  start();
  ASSERT_TRUE(eventually([&] { return bus_.opened() >= 4; }));
  EXPECT_GE(driver::monotonic_ns() - begin_ns, 700'000'000) << "0.1, 0.2 and 0.4 s";
  EXPECT_TRUE(is_stale(10, DWELL_FAULT_DISCONNECTED));
  bus_.fail_always(0);
  ASSERT_TRUE(eventually([&] {
    send_both();
    return delivers(10) && delivers(12);
  }));
}

TEST_F(CanFault, OpensAnInterfaceAnewThatWasRemoved) {
  start();
  send_both();
  ASSERT_TRUE(eventually([&] { return delivers(12); }));
  bus_.refuse("can0: there is no such interface");
  bus_.fail(ENODEV);
  ASSERT_TRUE(eventually([&] { return is_stale(10, DWELL_FAULT_DISCONNECTED) && bus_.opened() >= 2; }));
  bus_.refuse("");
  ASSERT_TRUE(eventually([&] { return bus_.is_open(); }));
  send_both();
  ASSERT_TRUE(eventually([&] { return delivers(10) && delivers(12); }));
  send(9);
  ASSERT_TRUE(eventually([&] { return host_.samples(10).back().raw == 9.0; }));
  EXPECT_EQ(host_.samples(10).back().flags, 0U);
}

TEST_F(CanFault, CallsAChannelStaleThreeFramesAfterItsLastNumber) {
  start();
  send();
  ASSERT_TRUE(eventually([&] { return delivers(11); }));
  for (int i = 0; i < 3; ++i) bus_.arrive(1, {1, 0, 0, 0xC0, 0x7F, 0, 0, 0});  // not a number
  ASSERT_TRUE(eventually([&] { return is_stale(11, DWELL_FAULT_INVALID_VALUE); }));
  EXPECT_TRUE(delivers(10));
  EXPECT_EQ(host_.counted(DWELL_FAULT_INVALID_VALUE), 3);
  EXPECT_EQ(host_.samples(10).size(), 4U);
  EXPECT_EQ(host_.samples(11).size(), 1U);
  send();
  ASSERT_TRUE(eventually([&] { return delivers(11); }));
}

TEST_F(CanFault, TakesNoSignalFromAFrameThatIsTooShort) {
  start();
  for (int i = 0; i < 3; ++i) bus_.arrive(1, {9});
  ASSERT_TRUE(eventually([&] { return is_stale(11, DWELL_FAULT_SHORT_FRAME); }));
  EXPECT_EQ(host_.counted(DWELL_FAULT_SHORT_FRAME), 3);
  EXPECT_EQ(host_.samples(10).size(), 3U);
}

TEST_F(CanFault, CallsOnlyTheChannelStaleWhoseFrameStaysAway) {
  for (Channel& channel : setup_.channels) channel.timeout_ns = 200'000'000;
  start();
  ASSERT_TRUE(eventually([&] {
    send();
    return is_stale(12, DWELL_FAULT_TIMEOUT) && delivers(10);
  }));
  EXPECT_EQ(host_.state_of(12).reason, "Two.Byte: no frame for 0.2 s");
  EXPECT_EQ(host_.counted(DWELL_FAULT_TIMEOUT), 1);
  bus_.arrive(2, {1});
  ASSERT_TRUE(eventually([&] { return delivers(12); }));
}

TEST_F(CanFault, SeesSilenceAndStopsOnABusThatNeverCeases) {
  for (Channel& channel : setup_.channels) channel.timeout_ns = 100'000'000;
  start();
  bus_.babble(true);
  ASSERT_TRUE(eventually([&] { return is_stale(10, DWELL_FAULT_TIMEOUT) && is_stale(12, DWELL_FAULT_TIMEOUT); }));
  stop();
}

TEST_F(CanFault, AdvancesEvenWhenStampsDoNot) {
  start();
  socketcan::Packet packet;
  packet.frame.can_id = 2;
  packet.frame.len = 1;
  packet.size = CAN_MTU;
  packet.real_ns = 0;  // none
  for (int i = 0; i < 200; ++i) bus_.arrive(packet);
  ASSERT_TRUE(eventually([&] { return host_.sample_count() == 200; }));
  const auto samples = host_.samples(12);
  for (const dwell_sample& sample : samples)
    EXPECT_EQ(sample.flags & DWELL_SAMPLE_STAMP_REPLACED, DWELL_SAMPLE_STAMP_REPLACED);
  for (std::size_t i = 1; i < samples.size(); ++i) EXPECT_GT(samples[i].t_ns, samples[i - 1].t_ns);
}

TEST_F(CanFault, WarnsOnceOfAGroupThatComesFromTwoAddresses) {
  setup_.wanted[2].match = {0x18FEF100, true, true, -1};
  start();
  for (const canid_t id : {0x18FEF121U, 0x18FEF121U, 0x18FEF122U, 0x18FEF121U}) bus_.arrive(id | CAN_EFF_FLAG, {5});
  ASSERT_TRUE(eventually([&] { return host_.sample_count() == 4; }));
  ASSERT_EQ(host_.logged().size(), 1U);
  EXPECT_NE(host_.logged()[0].find("33 and 34"), std::string::npos);
}

// Random identifiers, lengths and multiplexers: nothing but counts.
TEST_F(CanFault, SurvivesAHostileStream) {
  start();
  std::uint32_t random = 1;
  for (int i = 0; i < 20'000; ++i) {
    socketcan::Packet packet;
    for (std::uint8_t& byte : std::span(reinterpret_cast<std::uint8_t*>(&packet.frame), sizeof packet.frame))
      byte = static_cast<std::uint8_t>((random = random * 1664525U + 1013904223U) >> 24U);
    packet.size = i % 7 == 0 ? 1 + packet.frame.len : i % 2 == 0 ? CAN_MTU : CANFD_MTU;
    packet.real_ns = std::int64_t{packet.frame.can_id} << 31U;
    bus_.arrive(packet);
  }
  send(42);
  ASSERT_TRUE(eventually([&] {
    const auto samples = host_.samples(10);
    return !samples.empty() && samples.back().raw == 42.0;
  }));
  for (const dwell_sample& sample : host_.samples()) EXPECT_TRUE(std::isfinite(sample.raw));
}

}  // namespace
}  // namespace dwell::can
