// The rig as CANopen nodes: what they answer, what a SYNC gives, and each fault doing what its name says.
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <filesystem>
#include <map>

#include "drivers/socketcan/bus.hpp"
#include "tests/rigsim/rig_fixture.hpp"

namespace rigsim {
namespace {

using namespace test;
using dwell::socketcan::Bus;

class CanopenRig : public Rig {
 protected:
  CanopenRig() {
    options.tcp_port.reset();
    options.canopen =
        "unix:" + (std::filesystem::temp_directory_path() / ("rigsim-canopen-" + std::to_string(::getpid()))).string();
  }
  void start() {
    Rig::start();
    ASSERT_EQ(bus_.open(), "");
    await([&] { return send(0, {0x81, 0}) == 0; });
    await([&] {
      listen();
      return boots_ >= kChannels;
    });
  }
  int send(canid_t id, std::initializer_list<std::uint8_t> bytes) {
    canfd_frame frame{};
    frame.can_id = id;
    frame.len = static_cast<std::uint8_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), frame.data);
    return bus_.write(frame);
  }
  void listen() {
    for (const auto& frame : bus_.read().frames) {
      if (frame.can.can_id > 0x700 && frame.can.data[0] == 0) ++boots_;
      last_[frame.can.can_id] = frame.can;
      ++count_[frame.can.can_id];
    }
  }
  // Waits for the next frame of this identifier.
  const canfd_frame& next(canid_t id) {
    const int before = count_[id];
    await([&] {
      listen();
      return count_[id] > before;
    });
    return last_[id];
  }
  static std::uint32_t number(const std::uint8_t* bytes) {
    return bytes[0] | std::uint32_t{bytes[1]} << 8U | std::uint32_t{bytes[2]} << 16U | std::uint32_t{bytes[3]} << 24U;
  }

  Bus bus_{"bus", [this] { return dwell::socketcan::open_socket(options.canopen, {}); }};
  std::map<canid_t, canfd_frame> last_;
  std::map<canid_t, int> count_;
  int boots_ = 0;
};

TEST_F(CanopenRig, AnswersASyncWithTheModelOnceStarted) {
  start();
  set_time(1.2345);
  const auto expected = truth(1.2345);
  send(0, {1, 0});
  send(0x80, {});
  EXPECT_NEAR(std::bit_cast<float>(number(next(0x185).data)), expected[4], 1e-5);
  EXPECT_EQ(count_[0x181], 0);  // as delivered its TPDO is sent at events
  send(0, {0x80, 1});
  send(0x601, {0x23, 0x00, 0x18, 1, 0x81, 0x01, 0x00, 0x80});
  send(0x601, {0x2F, 0x00, 0x18, 2, 1, 0, 0, 0});
  send(0x601, {0x23, 0x00, 0x18, 1, 0x81, 0x01, 0x00, 0x00});
  send(0, {1, 1});
  send(0x80, {});
  EXPECT_NEAR(static_cast<std::int32_t>(number(next(0x181).data)), expected[0] / 1e-9, 1.0);
}

TEST_F(CanopenRig, TellsItsObjectsAndAbortsWhatIsNone) {
  start();
  send(0x604, {0x40, 0x18, 0x10, 4, 0, 0, 0, 0});
  EXPECT_EQ(number(next(0x584).data + 4), 1004U);
  send(0x604, {0x40, 0x18, 0x10, 5, 0, 0, 0, 0});
  EXPECT_EQ(number(next(0x584).data + 4), 0x06090011U);
  send(0x604, {0x40, 0x99, 0x20, 0, 0, 0, 0, 0});
  EXPECT_EQ(number(next(0x584).data + 4), 0x06020000U);
  set_time(0.5);
  send(0x604, {0x40, 0x30, 0x91, 1, 0, 0, 0, 0});
  EXPECT_NEAR(static_cast<std::int32_t>(number(next(0x584).data + 4)), truth(0.5)[3] / 1e-9, 1.0);
}

TEST_F(CanopenRig, RestartsRemapsAndSendsEmergencies) {
  start();
  ok("mapping 1 wrong");
  next(0x701);
  send(0x601, {0x40, 0x00, 0x1A, 1, 0, 0, 0, 0});
  EXPECT_EQ(number(next(0x581).data + 4), 0x60300110U);
  ok("mapping 1 right");
  next(0x701);
  ok("emergency 2 16912");
  EXPECT_EQ(number(next(0x82).data) & 0xFFFFU, 0x4210U);
  ok("node 2 off");
  send(0x602, {0x40, 0x00, 0x10, 0, 0, 0, 0, 0});
  ok("node 2 on");
  next(0x702);
  EXPECT_EQ(count_[0x582], 0);
  ok("node-reset all");
  next(0x705);
  EXPECT_NE(server->command("node-reset 6"), "ok");
  EXPECT_NE(server->command("emergency 1 x"), "ok");
  EXPECT_NE(server->command("status").find("\"nodes\":5"), std::string::npos);
}

TEST_F(CanopenRig, BabblesAndLeavesTheBus) {
  options.faults.babble_hz = 5000;
  start();
  next(0x001);
  ok("babble 0");
  ok("bus-off");
  await([&] {
    listen();
    return bus_.controller() == dwell::socketcan::Controller::bus_off;
  });
  EXPECT_NE(server->command("status").find("\"canopen_bus_off\":true"), std::string::npos);
  ok("restart");
  EXPECT_NE(server->command("status").find("\"canopen_bus_off\":false"), std::string::npos);
  send(0x605, {0x40, 0x00, 0x10, 0, 0, 0, 0, 0});
  next(0x585);
  ok("error-passive");
  await([&] {
    listen();
    return bus_.controller() == dwell::socketcan::Controller::passive;
  });
}

TEST_F(CanopenRig, LosesAndDelaysWhatNodesSend) {
  start();
  send(0, {1, 0});
  ok("missing 1");
  for (int i = 0; i < 3; ++i) send(0x80, {});
  await([&] { return server->command("status").find("\"canopen_frames_lost\":0,") == std::string::npos; });
  ok("missing 0");
  ok("late-by 0.02");
  ok("late 1");
  send(0x80, {});
  next(0x185);
  EXPECT_EQ(server->command("status").find("\"canopen_frames_late\":0,"), std::string::npos);
}

}  // namespace
}  // namespace rigsim
