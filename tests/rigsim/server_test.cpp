// The rig as a client sees it: true values at a known instant, and each fault doing what its name says.
#include "tests/rigsim/server.hpp"

#include <gtest/gtest.h>
#include <sys/un.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <functional>
#include <random>
#include <thread>

#include "tests/rigsim/rig_fixture.hpp"

namespace rigsim {
namespace {

using namespace test;

TEST_F(Rig, ServesTheModelAtTheInstantInEveryTypeAndOrder) {
  start();
  for (const double t_s : {0.1, 1.2345, 60.03}) {
    set_time(t_s);
    const auto expected = truth(t_s);
    for (int unit = 1; unit <= kStations; ++unit) {
      const Station which = *station(unit);
      const auto got = read(unit);
      ASSERT_EQ(got.size(), 5U);
      for (std::size_t i = 0; i < 5; ++i) {
        if (which.type == Type::float64)
          EXPECT_NEAR(got[i], expected[i], 1e-11 * kFull[i]);  // t differs in its last bit
        else if (which.floating())
          EXPECT_NEAR(got[i], expected[i], 6e-8 * std::abs(expected[i]) + 1e-11 * kFull[i]);
        else
          EXPECT_NEAR((got[i] - which.bias()) * which.step(i == 4), expected[i], 0.501 * which.step(i == 4)) << unit;
      }
    }
  }
}

TEST_F(Rig, HasTheSameInBothTables) {
  start();
  set_time(0.77);
  EXPECT_EQ(read(1, 3), read(1, 4));
}

TEST_F(Rig, ServesMillimetresAndNewtons) {
  options.millimetres = true;
  start();
  set_time(0.77);
  const auto got = read(5), expected = truth(0.77);
  EXPECT_NEAR(got[1], 1e3 * expected[1], 1e-12);
  EXPECT_NEAR(got[4], expected[4], 1e-9);
}

TEST_F(Rig, IsSampledInTheMiddleOfTheTurnaround) {
  options.faults.latency_s = 0.004;
  start();
  set_time(0.5);
  const auto got = read(5), expected = truth(0.502);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(got[i], expected[i], 1e-11 * kFull[i]);
}

TEST_F(Rig, ClockDrifts) {
  options.clock_drift_ppm = 1000;
  start();
  set_time(10.0);
  EXPECT_NEAR(server->simulated_time_s(10'000'000'000), 10.01, 1e-9);
  EXPECT_NEAR(read(5)[1], truth(10.01)[1], 1e-12);
  ok("clock-drift 0");
  EXPECT_NEAR(server->simulated_time_s(11'000'000'000), 11.01, 1e-9);
}

TEST_F(Rig, ChangesItsDriveWhileRunning) {
  start();
  set_time(5.0);
  const auto before = read(5);
  ok("frequency 6");
  const auto after = read(5);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(after[i], before[i], 1e-12 * kFull[i]);
  ok("amplitude 0.002");
  set_time(65.0);
  double largest = 0.0;
  for (int i = 0; i < 200; ++i) {
    set_time(65.0 + i / 1200.0);
    largest = std::max(largest, std::abs(read(5)[0]));
  }
  EXPECT_NEAR(largest, 0.002, 1e-6);
  ok("stop");
  set_time(165.0);
  EXPECT_NEAR(read(5)[3], 0.0, 1e-9);
  ok("start");
  set_time(165.0 + 0.3);
  EXPECT_GT(std::abs(read(5)[0]), 1e-6);
}

TEST_F(Rig, NoiseHasTheStatedSpread) {
  options.faults.noise = 0.01;
  options.from_steady = true;
  start();
  set_time(0.0);
  double sum = 0.0;
  constexpr int kReadings = 4000;
  for (int i = 0; i < kReadings; ++i) sum += std::pow(read(5)[0], 2);  // the table stands at zero
  // The standard deviation of a standard deviation from 4000 readings is 1.1 %.
  EXPECT_NEAR(std::sqrt(sum / kReadings), 0.01 * options.drive.amplitude, 0.06 * 0.01 * options.drive.amplitude);
}

TEST_F(Rig, QuantizesInStepsOfTheStatedSize) {
  options.faults.quantize = 0.1;
  start();
  for (int i = 0; i < 50; ++i) {
    set_time(0.013 * i);
    const double steps = read(5)[0] / (0.1 * options.drive.amplitude);
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
  }
}

TEST_F(Rig, SaysNoNumberWhereAReadingIsInvalid) {
  options.faults.invalid = 1.0;
  start();
  EXPECT_TRUE(std::isnan(read(1)[2]));
  EXPECT_EQ(read(9)[2], -2147483648.0);
}

TEST_F(Rig, AStuckChannelStaysWhereItWas) {
  start();
  set_time(1.0);
  ok("stuck y2 on");
  const auto then = read(5);
  set_time(1.1);
  const auto now = read(5);
  EXPECT_EQ(now[2], then[2]);
  EXPECT_NE(now[1], then[1]);
  ok("stuck y2 off");
  EXPECT_NE(read(5)[2], then[2]);
}

TEST_F(Rig, RefusesWhatIsNotThereWithTheProperException) {
  start();
  EXPECT_EQ(exception_of(ask_tcp(client, 1, Bytes{6, 0, 0, 0, 0})), kIllegalFunction);
  EXPECT_EQ(exception_of(ask_tcp(client, 1, read_pdu(9, 2))), kIllegalAddress);
  EXPECT_EQ(exception_of(ask_tcp(client, 1, read_pdu(0, 126))), kIllegalValue);
  EXPECT_EQ(exception_of(ask_tcp(client, 99, read_pdu(0, 2))), kNoSuchTarget);
  ok("exception 1");
  EXPECT_EQ(exception_of(ask_tcp(client, 1, read_pdu(0, 2))), kDeviceFailure);
}

TEST_F(Rig, AMissingAnswerNeverComes) {
  start();
  ok("missing 1");
  send(1);
  await([&] { return requests() == 1; });
  ok("missing 0");
  send(2);
  EXPECT_EQ(transaction_of(receive_tcp(client)), 2);
}

TEST_F(Rig, ALateAnswerComesAfterTheNextOne) {
  start();
  ok("late-by 0.3");
  ok("late 1");
  send(1);
  await([&] { return requests() == 1; });
  ok("late 0");
  send(2);
  EXPECT_EQ(transaction_of(receive_tcp(client)), 2);
  EXPECT_EQ(transaction_of(receive_tcp(client)), 1);
}

TEST_F(Rig, ADropOutEndsByItself) {
  start();
  ok("dropout-length 0.05");
  ok("drop 1");
  send(1);
  await([&] { return requests() == 1; });
  ok("drop 0");
  std::uint16_t transaction = 1;
  Bytes answer;
  for (int tries = 0; tries < 400 && answer.empty(); ++tries) {
    send(++transaction);
    answer = receive_bytes(client, 13, 0.05);
  }
  EXPECT_GT(transaction_of(answer), 1);
}

TEST_F(Rig, AWrongIdIsAnotherTransactions) {
  start();
  ok("wrong-id 1");
  send(7);
  EXPECT_EQ(transaction_of(receive_tcp(client)), 8);
}

TEST_F(Rig, AShortFrameIsHalfOfOne) {
  start();
  ok("short 1");
  send(7);
  EXPECT_EQ(receive_bytes(client, 6).size(), 6U);  // of 13
  ok("short 0");
  send(8);
  EXPECT_EQ(transaction_of(receive_tcp(client)), 8);
}

TEST_F(Rig, AResetEndsTheConnectionNotTheRig) {
  start();
  ok("reset 1");
  send(1);
  EXPECT_TRUE(receive_tcp(client).empty());
  ok("reset 0");
  client = connect_tcp(server->tcp_port());
  EXPECT_EQ(read().size(), 5U);
  ok("reset");
  EXPECT_TRUE(receive_tcp(client).empty());
}

TEST_F(Rig, ASilentRigListensWithoutAnswering) {
  start();
  ok("silent on");
  send(1);
  await([&] { return requests() == 1; });
  ok("silent off");
  send(2);
  EXPECT_EQ(transaction_of(receive_tcp(client)), 2);
}

TEST_F(Rig, SwitchedOffItRefusesConnectionsAndComesBackOnTheSamePort) {
  start();
  ok("listen off");
  EXPECT_TRUE(receive_tcp(client).empty());
  EXPECT_FALSE(connect_tcp(server->tcp_port()));
  ok("listen on");
  client = connect_tcp(server->tcp_port());
  EXPECT_EQ(read().size(), 5U);
}

TEST_F(Rig, AnswersRequestsOfOneConnectionInOrder) {
  options.faults.latency_s = 0.001;
  start();
  for (std::uint16_t i = 1; i <= 20; ++i) send(i);
  for (int i = 1; i <= 20; ++i) EXPECT_EQ(transaction_of(receive_tcp(client)), i);
}

TEST_F(Rig, SurvivesRandomBytesAndServesOn) {
  start();
  std::mt19937_64 random(4);
  for (int i = 0; i < 100; ++i) {
    const Fd other = connect_tcp(server->tcp_port());
    Bytes bytes(1 + random() % 4000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (bytes.size() > 6 && (random() & 1U) != 0) bytes[2] = bytes[3] = bytes[4] = 0;
    send_bytes(other, bytes);
  }
  EXPECT_EQ(read().size(), 5U);
}

TEST_F(Rig, AnswersControlLinesWithOkOrTheReason) {
  start();
  for (const char* line : {"noise 0.001", "latency 0", "clock-drift 20", "ramp 0.1", "offset 0.001", "stuck y0 off"})
    ok(line);
  for (const char* line : {"", "nonsense", "noise", "noise x", "noise -1", "noise 1 2", "missing 1.5", "frequency nan",
                           "stuck y9 on", "stuck y1", "silent maybe", "stop now", "reset 2"})
    EXPECT_EQ(server->command(line).rfind("error: ", 0), 0U) << line;
  EXPECT_EQ(server->command(std::string(1000, 'x')).rfind("error: ", 0), 0U);
  EXPECT_EQ(server->command("status").rfind("ok {\"t_s\":", 0), 0U);
  EXPECT_EQ(server->command("truth").rfind("ok {\"boundary\":\"clamped\"", 0), 0U);
}

TEST_F(Rig, TakesControlLinesFromItsSocket) {
  options.control_path = std::filesystem::temp_directory_path() / ("rigsim-test-" + std::to_string(::getpid()));
  start();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  options.control_path.copy(address.sun_path, sizeof address.sun_path - 1);
  const Fd control(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_EQ(::connect(control.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const std::string lines = "exception 1\nstuck y0 on\n";
  send_bytes(control, Bytes(lines.begin(), lines.end()));
  EXPECT_EQ(receive_bytes(control, 6), (Bytes{'o', 'k', '\n', 'o', 'k', '\n'}));
  EXPECT_EQ(exception_of(ask_tcp(client, 1, read_pdu(0, 2))), kDeviceFailure);
  send_bytes(control, Bytes(5000, 'x'));
  EXPECT_NE(receive_bytes(control, 7), Bytes{});
  EXPECT_EQ(exception_of(ask_tcp(client, 1, read_pdu(0, 2))), kDeviceFailure);
  server.reset();
  EXPECT_FALSE(std::filesystem::exists(options.control_path));
}

TEST(ServerStart, SaysWhyItCannot) {
  Options options;
  auto first = Server::start(options);
  ASSERT_TRUE(first);
  options.tcp_port = (*first)->tcp_port();
  auto second = Server::start(options);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().find("Address already in use"), std::string::npos);
  options.tcp_port = 0;
  options.chain.damping.pop_back();
  EXPECT_FALSE(Server::start(options));
}

}  // namespace
}  // namespace rigsim
