// RTU, on a real pseudo-terminal.
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "tests/rigsim/rig_fixture.hpp"

namespace rigsim {
namespace {

using namespace test;

class RtuRig : public Rig {
 protected:
  void start_rtu(speed_t speed = B115200) {
    options.rtu = true;
    options.tcp_port.reset();
    start();
    line = open_serial(server->rtu_path(), speed);
  }
  void ask(int unit, std::uint16_t address = 0) {
    send_bytes(line, rtu_frame(static_cast<std::uint8_t>(unit), read_pdu(address, 2)));
  }
  static bool good(const Bytes& frame) {
    return frame.size() > 4 && rtu_frame(frame[0], std::span(frame).subspan(1, frame.size() - 3)) == frame;
  }
  Fd line;
};

TEST_F(RtuRig, AnswersAnyStationWithAGoodCrc) {
  start_rtu();
  for (const int unit : {1, 2, 24}) {
    ask(unit);
    const Bytes frame = receive_bytes(line, 9);
    EXPECT_TRUE(good(frame));
    EXPECT_EQ(frame[0], unit);
  }
}

TEST_F(RtuRig, ServesTheModelAfterTheRequestsWireTime) {
  options.baud = 9600;
  options.parity = false;
  start_rtu();
  set_time(0.5);
  send_bytes(line, rtu_frame(1, read_pdu(2, 2)));
  const Bytes frame = receive_bytes(line, 9);
  ASSERT_TRUE(good(frame));
  // Eight characters of ten bits.
  EXPECT_NEAR(decode(frame.data() + 3, *station(1)), truth(0.5 + 80.0 / 9600)[1], 1e-9);
}

TEST_F(RtuRig, TakesTheTimeThatBytesNeedOnTheWire) {
  start_rtu(B9600);
  const auto before = std::chrono::steady_clock::now();
  ask(1);
  EXPECT_TRUE(good(receive_bytes(line, 9)));
  EXPECT_GE(std::chrono::steady_clock::now() - before, std::chrono::duration<double>(187.0 / 9600));
}

TEST_F(RtuRig, NobodyAnswersForAStationThatIsNotThere) {
  start_rtu();
  ask(77);
  await([&] { return requests() == 1; });
  ask(3);
  EXPECT_EQ(receive_bytes(line, 9).at(0), 3);
}

TEST_F(RtuRig, FaultsOfTheLineDoWhatTheyAreCalled) {
  start_rtu();
  ok("bad-crc 1");
  ask(1);
  const Bytes bad = receive_bytes(line, 9);
  EXPECT_EQ(bad.size(), 9U);
  EXPECT_FALSE(good(bad));
  ok("bad-crc 0");
  ok("wrong-id 1");
  ask(1);
  EXPECT_EQ(receive_bytes(line, 9).at(0), 2);
  ok("wrong-id 0");
  ok("short 1");
  ask(1);
  EXPECT_EQ(receive_bytes(line, 9, 0.5).size(), 4U);
  ok("short 0");
  ok("exception 1");
  ask(1);
  const Bytes refused = receive_bytes(line, 5);
  EXPECT_TRUE(good(refused));
  EXPECT_EQ(refused.at(2), kDeviceFailure);
}

TEST_F(RtuRig, ComesBackAfterGarbage) {
  start_rtu();
  std::mt19937_64 random(6);
  for (int round = 0; round < 20; ++round) {
    Bytes bytes(1 + random() % 40);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    send_bytes(line, bytes);
  }
  // Until the line has been silent long enough for the rig to forget the last of it.
  Bytes frame;
  for (int tries = 0; tries < 100 && !good(frame); ++tries) {
    ask(1);
    frame = receive_bytes(line, 9, 0.2);
  }
  EXPECT_TRUE(good(frame));
}

TEST_F(RtuRig, LinksItsTerminalAndRemovesTheLink) {
  options.rtu_link = std::filesystem::temp_directory_path() / ("rigsim-rtu-" + std::to_string(::getpid()));
  start_rtu();
  EXPECT_EQ(server->rtu_path(), options.rtu_link);
  ask(1);
  EXPECT_TRUE(good(receive_bytes(line, 9)));
  server.reset();
  EXPECT_FALSE(std::filesystem::is_symlink(options.rtu_link));
}

}  // namespace
}  // namespace rigsim
