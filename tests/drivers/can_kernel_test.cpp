// The socket seam on the kernel's own CAN: what the tests above it take for granted. Skipped where the kernel has no
// vcan.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/bus.hpp"
#include "tests/drivers/can_device.hpp"
#include "tests/drivers/fake_host.hpp"

namespace dwell::socketcan {
namespace {

using test::can_frame_of;
using test::eventually;
using test::VirtualCan;

class CanKernel : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!VirtualCan::possible()) GTEST_SKIP() << "this needs a kernel with vcan, and the right to make interfaces";
    ASSERT_TRUE(interface_.come());
    ASSERT_EQ(bus_.open(), "");
    reopen_sender();
  }
  void reopen_sender() {
    auto opened = open_socket(interface_.name(), {});
    ASSERT_TRUE(opened) << opened.error();
    sender_ = std::move(*opened);
  }
  int send(canid_t id, const std::vector<std::uint8_t>& data) {
    const rigsim::WireFrame frame = can_frame_of(id, data);
    return sender_->write(frame.can, frame.fd);
  }
  // Reads until `enough`, adding up what came.
  bool listen(const std::function<bool()>& enough) {
    return eventually([&] {
      const Receipt receipt = bus_.read();
      for (const Frame& frame : receipt.frames) frames_.push_back(frame);
      lost_ += receipt.lost;
      errors_ += receipt.errors;
      bus_off_ = bus_off_ || receipt.bus_off;
      restarted_ = restarted_ || receipt.restarted;
      if (receipt.error != 0) error_ = receipt.error;
      return enough();
    });
  }

  VirtualCan interface_;
  std::vector<can_filter> filters_;
  Bus bus_{"bus", [this] { return open_socket(interface_.name(), filters_); }};
  std::unique_ptr<Socket> sender_;
  std::vector<Frame> frames_;
  std::uint64_t lost_ = 0;
  unsigned errors_ = 0;
  bool bus_off_ = false, restarted_ = false;
  int error_ = 0;
};

TEST_F(CanKernel, CarriesClassicAndFdFramesWithStandardAndExtendedIdentifiers) {
  ASSERT_EQ(send(0x123, {1, 2}), 0);
  ASSERT_EQ(send(0x123 | CAN_EFF_FLAG, std::vector<std::uint8_t>(64, 7)), 0);
  ASSERT_TRUE(listen([&] { return frames_.size() == 2; }));
  EXPECT_EQ(frames_[0].can.can_id, 0x123U);
  EXPECT_EQ(frames_[0].can.len, 2);
  EXPECT_FALSE(frames_[0].fd);
  EXPECT_EQ(frames_[1].can.can_id, 0x123U | CAN_EFF_FLAG);
  EXPECT_EQ(frames_[1].can.len, 64);
  EXPECT_EQ(frames_[1].can.data[63], 7);
  EXPECT_TRUE(frames_[1].fd);
}

TEST_F(CanKernel, PassesWhatTheFiltersSayAndNothingElse) {
  filters_ = {{0x123, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG},
              {0x18FF5000U | CAN_EFF_FLAG, 0x3FFFF00U | CAN_EFF_FLAG | CAN_RTR_FLAG}};
  ASSERT_EQ(bus_.open(), "");
  for (const canid_t id : {0x122U, 0x123U | CAN_EFF_FLAG, 0x123U | CAN_RTR_FLAG, 0x18FF5121U | CAN_EFF_FLAG, 0x123U,
                           0x0CFF5042U | CAN_EFF_FLAG})
    ASSERT_EQ(send(id, {}), 0);
  ASSERT_TRUE(listen([&] { return frames_.size() >= 2; }));
  ASSERT_EQ(frames_.size(), 2U);
  EXPECT_EQ(frames_[0].can.can_id, 0x123U);
  EXPECT_EQ(frames_[1].can.can_id, 0x0CFF5042U | CAN_EFF_FLAG);
}

TEST_F(CanKernel, StampsAFrameBetweenTheInstantsAroundItsSending) {
  for (int i = 0; i < 200; ++i) {
    frames_.clear();
    const std::int64_t before_ns = driver::raw_ns();
    ASSERT_EQ(send(1, {}), 0);
    const std::int64_t after_ns = driver::raw_ns();
    ASSERT_TRUE(listen([&] { return !frames_.empty(); }));
    const Stamp& stamp = frames_[0].stamp;
    EXPECT_FALSE(stamp.replaced);
    EXPECT_GE(stamp.t_ns + stamp.t_half_ns + 1000, before_ns);
    // A frame is queued for its receivers by a soft interrupt, mostly before the sender goes on.
    EXPECT_LE(stamp.t_ns - std::int64_t{stamp.t_half_ns}, after_ns + 20'000'000);
  }
}

TEST_F(CanKernel, CountsEveryFrameThatWasLostForLackOfRoom) {
  std::uint64_t sent = 0;
  for (; sent < 5'000; ++sent) ASSERT_EQ(send(1, {1}), 0);
  // The count comes with the next frame that finds room.
  ASSERT_TRUE(listen([&] {
    if (frames_.size() + lost_ == sent) return true;
    ++sent;
    send(1, {1});
    return false;
  }));
  EXPECT_GT(lost_, 0U);
  EXPECT_GT(frames_.size(), 100U);
}

TEST_F(CanKernel, HearsErrorFrames) {
  ASSERT_EQ(send(CAN_ERR_FLAG | CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_PASSIVE, 0, 0, 0, 0, 0, 0}), 0);
  ASSERT_TRUE(listen([&] { return bus_.controller() == Controller::passive; }));
  EXPECT_EQ(errors_, 1U);
  ASSERT_EQ(send(CAN_ERR_FLAG | CAN_ERR_BUSOFF, {0, 0, 0, 0, 0, 0, 0, 0}), 0);
  ASSERT_TRUE(listen([&] { return bus_off_; }));
  ASSERT_EQ(send(CAN_ERR_FLAG | CAN_ERR_RESTARTED, {0, 0, 0, 0, 0, 0, 0, 0}), 0);
  ASSERT_TRUE(listen([&] { return restarted_; }));
  EXPECT_EQ(bus_.controller(), Controller::active);
}

TEST_F(CanKernel, SaysWhenTheLinkGoesDownAndGoesOnWhenItIsUpAgain) {
  EXPECT_EQ(bus_.link(), Link::up);
  ASSERT_EQ(std::system(("ip link set " + interface_.name() + " down").c_str()), 0);
  ASSERT_TRUE(listen([&] { return error_ == ENETDOWN; }));
  EXPECT_EQ(bus_.link(), Link::down);
  ASSERT_TRUE(interface_.come());
  EXPECT_EQ(bus_.link(), Link::up);
  reopen_sender();
  ASSERT_EQ(send(1, {}), 0);
  ASSERT_TRUE(listen([&] { return frames_.size() == 1; }));
}

TEST_F(CanKernel, SaysThatTheLinkIsDownFromTheBeginning) {
  ASSERT_EQ(std::system(("ip link set " + interface_.name() + " down").c_str()), 0);
  ASSERT_EQ(bus_.open(), "");
  ASSERT_TRUE(listen([&] { return error_ == ENETDOWN; }));
}

TEST_F(CanKernel, SaysThatTheInterfaceWasRemovedAndFindsItAgain) {
  interface_.leave();
  ASSERT_TRUE(listen([&] { return error_ == ENODEV; }));
  EXPECT_EQ(bus_.open(), interface_.name() + ": there is no such interface");
  ASSERT_TRUE(interface_.come());
  ASSERT_EQ(bus_.open(), "");
  reopen_sender();
  ASSERT_EQ(send(1, {}), 0);
  ASSERT_TRUE(listen([&] { return frames_.size() == 1; }));
}

TEST_F(CanKernel, SaysThatAnInterfaceIsNoCanInterface) {
  const Opened opened = open_socket("lo", {});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error(), "lo: is not a CAN interface");
}

// Steps of an hour both ways and slews of 500 ppm while frames come: no stamp leaves the instants around its sending.
TEST_F(CanKernel, KeepsInstantsWhateverTheWallClockDoes) {
  if (std::getenv("DWELL_TEST_SETS_THE_CLOCK") == nullptr)
    GTEST_SKIP() << "this sets the clock of the machine: DWELL_TEST_SETS_THE_CLOCK=1 allows it to";
  const auto step = [](std::int64_t by_s) {
    timespec now{};
    ASSERT_EQ(::clock_gettime(CLOCK_REALTIME, &now), 0);
    now.tv_sec += by_s;
    ASSERT_EQ(::clock_settime(CLOCK_REALTIME, &now), 0);
  };
  const auto slew = [](double ppm) {
    timex change{};
    change.modes = ADJ_FREQUENCY;
    change.freq = static_cast<long>(ppm * 65536.0);
    ASSERT_GE(::adjtimex(&change), 0);
  };
  std::int64_t earliest_ns = 0, latest_ns = 0;
  int replaced = 0, frames = 0;
  for (int i = 0; i < 400; ++i) {
    if (i % 50 == 10) slew(i % 100 < 50 ? 500.0 : -500.0);
    frames_.clear();
    bus_.read();
    if (i % 8 == 1) step(i % 16 < 8 ? 3600 : -3600);  // between the reads, before the frame
    const std::int64_t before_ns = driver::raw_ns();
    ASSERT_EQ(send(1, {}), 0);
    const std::int64_t after_ns = driver::raw_ns();
    ::usleep(5'000);
    if (i % 8 == 5) step(i % 16 < 8 ? -3600 : 3600);  // … and after it
    ASSERT_TRUE(listen([&] { return !frames_.empty(); }));
    const Stamp& stamp = frames_[0].stamp;
    ++frames;
    replaced += stamp.replaced ? 1 : 0;
    earliest_ns = std::min(earliest_ns, stamp.t_ns - before_ns);
    latest_ns = std::max(latest_ns, stamp.t_ns - after_ns);
  }
  slew(0.0);
  EXPECT_EQ(replaced, 0) << "of " << frames;
  EXPECT_GE(earliest_ns, -10'000) << "a read with a step between lacks the slew of 5 ms: 2.5 us";
  EXPECT_LE(latest_ns, 20'000'000);
  RecordProperty("earliest_ns", std::to_string(earliest_ns));
  RecordProperty("latest_ns", std::to_string(latest_ns));
}

}  // namespace
}  // namespace dwell::socketcan
