// The rig as a client sees it: true values at a known instant, and each fault doing what its name says.
#include "tests/rigsim/server.hpp"

#include <gtest/gtest.h>
#include <sys/un.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <random>
#include <thread>

#include "tests/rigsim/client.hpp"

namespace rigsim {
namespace {

using namespace test;

constexpr int kChannels = 5;                                 // of the default rig: y0 … y3, reaction
constexpr double kFull[] = {0.005, 0.01, 0.01, 0.01, 50.0};  // their sizes

void await(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  while (!condition()) {
    ASSERT_LT(std::chrono::steady_clock::now(), end);
    std::this_thread::yield();
  }
}

// A rig whose clock stands still unless a test moves it.
class Rig : public ::testing::Test {
 protected:
  void start() {
    options.clock_ns = [this] { return clock_ns.load(); };
    auto made = Server::start(options);
    ASSERT_TRUE(made) << made.error();
    server = std::move(*made);
    if (options.tcp_port) client = connect_tcp(server->tcp_port());
  }
  void set_time(double t_s) { clock_ns = static_cast<std::int64_t>(std::llround(t_s * 1e9)); }
  void ok(const std::string& line) { EXPECT_EQ(server->command(line), "ok") << line; }

  // All channels by station `unit` in one request.
  std::vector<double> read(int unit = 1, std::uint8_t function = 4) {
    const Station which = *station(unit);
    const Bytes frame =
        ask_tcp(client, unit, read_pdu(0, static_cast<std::uint16_t>(kChannels * which.words()), function));
    std::vector<double> values;
    if (exception_of(frame) != 0) return values;
    for (int i = 0; i < kChannels; ++i) values.push_back(decode(frame.data() + 9 + 2 * i * which.words(), which));
    return values;
  }
  std::vector<double> truth(double t_s) const {
    dwell::DrivenChain chain(options.chain, options.drive, dwell::DrivenChain::Start::rest);
    const auto& motion = chain.at(t_s);
    std::vector<double> values = motion.y;
    values.push_back(motion.ground_force);
    return values;
  }
  std::uint64_t requests() {
    const std::string status = server->command("status");
    return std::stoull(status.substr(status.find("\"requests\":") + 11));
  }
  void send(std::uint16_t transaction) { send_bytes(client, tcp_frame(transaction, 1, read_pdu(0, 2))); }

  Options options;
  std::atomic<std::int64_t> clock_ns{0};
  std::unique_ptr<Server> server;
  Fd client;
};

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
  std::strcpy(address.sun_path, options.control_path.c_str());
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

// RTU, on a real pseudo-terminal.
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
  start_rtu();
  set_time(0.5);
  send_bytes(line, rtu_frame(1, read_pdu(2, 2)));
  const Bytes frame = receive_bytes(line, 9);
  ASSERT_TRUE(good(frame));
  // The client has set no parity and one stop bit: ten bits a character, eight characters.
  EXPECT_NEAR(decode(frame.data() + 3, *station(1)), truth(0.5 + 80.0 / 9600)[1], 1e-9);
}

TEST_F(RtuRig, TakesTheTimeThatBytesNeedOnTheWire) {
  start_rtu(B9600);
  const auto before = std::chrono::steady_clock::now();
  ask(1);
  EXPECT_TRUE(good(receive_bytes(line, 9)));
  EXPECT_GE(std::chrono::steady_clock::now() - before, std::chrono::duration<double>(170.0 / 9600));
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
