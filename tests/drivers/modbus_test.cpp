// The modbus plugin against devices that lie, dawdle and vanish.
#include <gtest/gtest.h>
#include <netdb.h>

#include <cmath>
#include <mutex>
#include <vector>

#include "drivers/modbus/decode.hpp"
#include "tests/drivers/modbus_fixture.hpp"

namespace dwell::test {
namespace {

using namespace std::chrono_literals;

TEST(ModbusPlugin, DeliversEveryTypeAndTable) {
  ModbusDevice device(ModbusDevice::Over::tcp, [](const Request& request) -> std::vector<Reply> {
    return {answer(request, [&](unsigned r) {
      std::array<std::uint16_t, 16> image{};
      modbus::encode(-2.5, modbus::Type::float32, modbus::Order::cdab, &image[0]);
      modbus::encode(1e-300, modbus::Type::float64, modbus::Order::abcd, &image[2]);
      image[6] = request.function == 3 ? 42 : 43;
      return r < image.size() ? image.at(r) : std::uint16_t{0};
    })};
  });
  Given given = over_tcp(device);
  given.channel("a").set("register", 0).set("type", "float32").set("order", "cdab");
  given.channel("b").set("register", 2).set("type", "float64");
  given.channel("c").set("register", 6).set("type", "int16").set("table", "holding");
  given.channel("d").set("register", 6).set("type", "int16").set("table", "input");
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 8; }));
  instance.stop();
  EXPECT_EQ(host.samples(10).at(0).raw, -2.5);
  EXPECT_EQ(host.samples(11).at(0).raw, 1e-300);
  EXPECT_EQ(host.samples(12).at(0).raw, 42.0);
  EXPECT_EQ(host.samples(13).at(0).raw, 43.0);
  EXPECT_EQ(host.scans().at(0) + host.scans().at(1), 4U) << "neighbours share a transaction, tables do not";
}

TEST(ModbusPlugin, NeverPushesWhatIsNotANumber) {
  ModbusDevice device(ModbusDevice::Over::tcp, [](const Request& request) -> std::vector<Reply> {
    return {answer(request, [](unsigned r) { return std::uint16_t(r == 0 ? 0x7FC0 : r == 2 ? 0x3F80 : 0); })};
  });
  Given given = over_tcp(device);
  given.channel("nan").set("register", 0).set("type", "float32");
  given.channel("one").set("register", 2).set("type", "float32");
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(
      eventually([&] { return host.state_of(10).fault == DWELL_FAULT_INVALID_VALUE && host.sample_count() > 3; }));
  instance.stop();
  EXPECT_TRUE(host.samples(10).empty());
  EXPECT_EQ(host.samples(11).at(0).raw, 1.0);
  EXPECT_EQ(host.state_of(11).fault, DWELL_FAULT_NONE);
  EXPECT_GE(host.counted(DWELL_FAULT_INVALID_VALUE), 3);
}

// Request n is answered with the value n; every third answer comes only just before that of the next request.
TEST(ModbusPlugin, NeverTakesALateAnswerForTheCurrentOneOverTcp) {
  Request held;
  ModbusDevice device(ModbusDevice::Over::tcp, [&held](const Request& request) -> std::vector<Reply> {
    const auto value_of = [](const Request& r) {
      return [n = r.number](unsigned) { return static_cast<std::uint16_t>(n); };
    };
    if (request.number % 3 == 0) {
      held = request;
      return {};
    }
    std::vector<Reply> replies;
    if (request.number % 3 == 1) {
      replies.push_back(answer(held, value_of(held)));
      replies.back().transaction = held.transaction;
    }
    replies.push_back(answer(request, value_of(request)));
    return replies;
  });
  Given given = over_tcp(device);
  given.set("timeout", 0.02);
  add_word(given, "n", 0);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 20; }));
  instance.stop();
  for (const dwell_sample& sample : host.samples()) EXPECT_NE(std::lround(sample.raw) % 3, 0);
  EXPECT_GE(host.counted(DWELL_FAULT_LATE_ANSWER), 9);
  EXPECT_GE(host.counted(DWELL_FAULT_TIMEOUT), 9);
}

// Request n is answered with the value n. If the driver is delayed, a late answer may be waiting when its timeout ends.
// It may take that, for it answers the current request; but not once the next request was sent.
TEST(ModbusPlugin, NeverTakesALateAnswerForTheCurrentOneOverSerial) {
  std::mutex mutex;
  std::vector<std::int64_t> came_ns;  // the requests
  ModbusDevice device(ModbusDevice::Over::serial, [&](const Request& request) -> std::vector<Reply> {
    const std::lock_guard lock(mutex);
    came_ns.push_back(driver::raw_ns());
    Reply reply = answer(request, [&](unsigned) { return static_cast<std::uint16_t>(request.number); });
    if (request.number % 3 == 0) reply.delay = 150ms;  // later than the timeout, earlier than the line's silence ends
    return {reply};
  });
  Given given = over_serial(device);
  given.set("timeout", 0.05).set("late", 0.4);
  add_word(given, "n", 0);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 8 && host.counted(DWELL_FAULT_LATE_ANSWER) >= 3; }));
  instance.stop();
  for (const dwell_sample& sample : host.samples()) {
    const std::lock_guard lock(mutex);
    const auto next = static_cast<std::size_t>(std::lround(sample.raw)) + 1;
    if (next < came_ns.size()) {
      EXPECT_LT(sample.t_ns + sample.t_half_ns, came_ns[next]) << "request " << sample.raw;
    }
  }
}

TEST(ModbusPlugin, MarksOnlyTheChannelsThatAreRefused) {
  ModbusDevice device(ModbusDevice::Over::tcp, [](const Request& request) -> std::vector<Reply> {
    if (request.first == 100) return {exception(request, 2)};
    return {answer(request, register_number)};
  });
  Given given = over_tcp(device);
  add_word(given, "good", 7);
  add_word(given, "bad", 100);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.state_of(11).fault == DWELL_FAULT_EXCEPTION; }));
  const std::size_t before = host.sample_count();
  ASSERT_TRUE(eventually([&] { return host.sample_count() > before + 5; }));
  instance.stop();
  EXPECT_EQ(host.state_of(11).reason, "station 1: registers 100 to 100: exception 2, Illegal data address");
  EXPECT_EQ(host.state_of(10).fault, DWELL_FAULT_NONE);
  EXPECT_GE(host.counted(DWELL_FAULT_EXCEPTION), 3);
}

TEST(ModbusPlugin, LetsNoDeadStationRuinTheOthersRate) {
  ModbusDevice device(ModbusDevice::Over::tcp, [](const Request& request) -> std::vector<Reply> {
    if (request.unit == 2) return {};
    return {answer(request, register_number)};
  });
  Given given = over_tcp(device);
  given.set("timeout", 0.05);
  add_word(given, "live", 1, 1);
  add_word(given, "dead", 2, 2);
  add_word(given, "alive", 3, 3);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.state_of(11).fault == DWELL_FAULT_TIMEOUT; }));
  EXPECT_EQ(host.state_of(11).reason, "station 2: no answer within 0.05 s");
  const std::size_t samples = host.sample_count();
  const int timeouts = host.counted(DWELL_FAULT_TIMEOUT);
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= samples + 400; }));
  instance.stop();
  // 200 polls, a second's worth; asked each time the dead station would have cost 200 timeouts.
  EXPECT_LE(host.counted(DWELL_FAULT_TIMEOUT) - timeouts, 10);
  EXPECT_EQ(host.state_of(10).fault, DWELL_FAULT_NONE);
  EXPECT_EQ(host.state_of(12).fault, DWELL_FAULT_NONE);
}

TEST(ModbusPlugin, BringsADeadStationBack) {
  std::atomic<bool> dead{true};
  ModbusDevice device(ModbusDevice::Over::tcp, [&](const Request& request) -> std::vector<Reply> {
    if (request.unit == 2 && dead) return {};
    return {answer(request, register_number)};
  });
  Given given = over_tcp(device);
  given.set("timeout", 0.02);
  add_word(given, "live", 1, 1);
  add_word(given, "dead", 2, 2);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.state_of(11).fault == DWELL_FAULT_TIMEOUT; }));
  dead = false;
  ASSERT_TRUE(eventually([&] { return host.state_of(11).fault == DWELL_FAULT_NONE; }));
  EXPECT_FALSE(host.samples(11).empty());
}

TEST(ModbusPlugin, ReconnectsToADeviceThatFellSilent) {
  std::atomic<bool> silent{true};
  ModbusDevice device(kTcp, [&](const Request& request) { return silent ? std::vector<Reply>{} : honest(request); });
  Given given = over_tcp(device);
  given.set("timeout", 0.02);
  add_word(given, "a", 0);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.counted(DWELL_FAULT_DISCONNECTED) >= 1; }));
  EXPECT_EQ(host.state_of(10).fault, DWELL_FAULT_TIMEOUT);
  silent = false;
  ASSERT_TRUE(eventually([&] { return host.state_of(10).fault == DWELL_FAULT_NONE; }));
}

TEST(ModbusPlugin, SkipsAndCountsTheDeadlinesItCannotKeep) {
  ModbusDevice device(kTcp, [](const Request& request) -> std::vector<Reply> {
    Reply reply = answer(request, register_number);
    reply.delay = 5ms;
    return {reply};
  });
  Given given = over_tcp(device);
  given.set("rate", 1000.0);
  add_word(given, "a", 0);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 20; }));
  instance.stop();
  EXPECT_GE(host.counted(DWELL_FAULT_MISSED_DEADLINE), 60);
}

TEST(ModbusPlugin, KeepsItsDeadlinesOverTime) {
  ModbusDevice device(kTcp, honest);
  Given given = over_tcp(device);
  given.set("rate", 500.0);
  add_word(given, "a", 0);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 250; }));
  instance.stop();
  const auto samples = host.samples();
  // Each poll that was not skipped moves the deadline by one period, so lateness never adds up.
  const double periods = static_cast<double>(samples.back().t_ns - samples.front().t_ns) / 2e6;
  const double expected = static_cast<double>(samples.size() - 1) + host.counted(DWELL_FAULT_MISSED_DEADLINE);
  EXPECT_NEAR(periods, expected, 0.05 * expected);
}

TEST(ModbusPlugin, TakesTheWireTimeOffOnlyWhereThereIsOne) {
  ModbusDevice device(kSerial, honest);
  Given given = over_serial(device);
  add_word(given, "a", 0);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  const std::int64_t before_ns = driver::raw_ns();
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 5; }));
  instance.stop();
  const std::int64_t after_ns = driver::raw_ns();
  for (const dwell_sample& sample : host.samples()) {
    EXPECT_GE(sample.t_ns, before_ns);
    EXPECT_LE(sample.t_ns, after_ns);
  }
}

TEST(ModbusPlugin, SplitsWhatExceedsTheMaximumOfOneTransaction) {
  std::atomic<int> largest{0};
  ModbusDevice device(kTcp, [&](const Request& request) {
    largest = std::max<int>(largest, request.count);
    return honest(request);
  });
  Given given = over_tcp(device);
  given.set("max_registers", 4);
  int first = 0;
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    given.channel(name).set("register", first).set("type", "uint32");
    first += 2;
  }
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 10; }));
  instance.stop();
  EXPECT_EQ(largest, 4);
  EXPECT_EQ(host.samples(14).at(0).raw, 8.0 * 65536 + 9);
}

TEST(ModbusPlugin, LooksUpNamesWithoutMakingStopWait) {
  addrinfo* found = nullptr;
  if (getaddrinfo("localhost", nullptr, nullptr, &found) != 0)
    GTEST_SKIP() << "this machine has no address for localhost";
  freeaddrinfo(found);
  ModbusDevice device(kTcp, honest);
  Given given("amplifier");
  given.set("transport", "tcp").set("host", "localhost").set("port", device.port());
  add_word(given, "a", 5);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() > 0; }));

  Given nowhere("amplifier");
  nowhere.set("transport", "tcp").set("host", "no-such-device.invalid");
  add_word(nowhere, "a", 5);
  FakeHost other;
  Instance lost(driver_table(), *nowhere.settings(), other);
  ASSERT_TRUE(lost.start());
  ASSERT_TRUE(eventually([&] { return other.state_of(10).fault == DWELL_FAULT_DISCONNECTED; }));
  EXPECT_NE(other.state_of(10).reason.find("no-such-device.invalid"), std::string::npos);
  EXPECT_LT(lost.stop(), 0.5);
}

// Two programs on one line take each other's answers: the second one gets none, and the first loses none.
TEST(ModbusPlugin, ASerialPortInUseIsRefusedToASecondProgram) {
  ModbusDevice device(kSerial, honest);
  Given given = over_serial(device);
  given.set("timeout", 2.0);  // a busy machine may hold up the device that answers
  add_word(given, "a", 5);
  FakeHost host;
  {
    Instance instance(driver_table(), *given.settings(), host);
    ASSERT_TRUE(instance.start());
    ASSERT_TRUE(eventually([&] { return host.sample_count() > 5; }));
    const auto results = probe(driver_table(), *given.settings());
    EXPECT_NE(results.at(0).error.find("in use by another program"), std::string::npos) << results.at(0).error;
    const std::size_t before = host.sample_count();
    ASSERT_TRUE(eventually([&] { return host.sample_count() > before + 5; }));
    EXPECT_EQ(host.counted(DWELL_FAULT_TIMEOUT), 0);
    instance.stop();
  }
  EXPECT_EQ(probe(driver_table(), *given.settings()).at(0).error, "");
}

TEST(ModbusPlugin, TwoChannelsOfOneRegisterAreAMistake) {
  Given given("amplifier");
  given.set("transport", "tcp").set("host", "10.0.0.1");
  given.channel("a").set("register", 0).set("type", "float32");
  given.channel("b").set("register", 2).set("type", "float32");
  given.channel("c").set("register", 1).set("type", "uint16");
  given.channel("d").set("register", 0).set("type", "float32").set("table", "holding");
  given.channel("e").set("register", 0).set("type", "float32").set("station", 2);
  given.channel("f").set("register", 2).set("type", "float32");
  const auto mistakes = mistakes_of(driver_table(), *given.settings());
  ASSERT_EQ(mistakes.size(), 2U);
  EXPECT_EQ(mistakes[0],
            "channel 2, register: register 1 (station 1, input) is read by channel \"a\" already; expected registers "
            "of its own");
  EXPECT_EQ(mistakes[1],
            "channel 5, register: register 2 (station 1, input) is read by channel \"b\" already; expected registers "
            "of its own");
}

TEST(ModbusPlugin, WarnsOfARateThatTheLineCannotCarry) {
  ModbusDevice device(kSerial, honest);
  Given given = over_serial(device);
  given.set("baud", 9600).set("rate", 500);
  add_word(given, "a", 0);
  FakeHost host;
  Instance instance(driver_table(), *given.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return !host.logged().empty(); }));
  EXPECT_NE(host.logged().at(0).find("more than the line can carry"), std::string::npos);
}

TEST(ModbusPlugin, ReportsEveryMistakeAtOnce) {
  Given given("line");
  given.set("transport", "rtu").set("host", "10.0.0.1").set("port", 502).set("baud", 12345);
  given.channel("a").set("register", 65535).set("type", "float32").set("station", 248);
  const auto mistakes = mistakes_of(driver_table(), *given.settings());
  ASSERT_EQ(mistakes.size(), 6U);
  EXPECT_EQ(mistakes[0],
            "device, transport: `serial` is missing; expected the serial port, for instance \"/dev/ttyUSB0\"");
  EXPECT_EQ(mistakes[1], "device, host: `host` is for transport = \"tcp\"");
  EXPECT_NE(mistakes[3].find("expected one of 600, 1200"), std::string::npos);
  EXPECT_EQ(mistakes[4],
            "channel 0, register: the value ends beyond register 65535; expected at most 65534 for its type");
  EXPECT_EQ(mistakes[5], "channel 0, station: station 248 cannot be on a serial line; expected 1 to 247");

  Given other("amplifier");
  other.set("transport", "tcp").set("serial", "/dev/ttyS0").set("late", 1.0);
  EXPECT_EQ(mistakes_of(driver_table(), *other.settings()).size(), 3U);
}

TEST(ModbusPlugin, ProbesEachChannelOnceAndSaysWhyOneCannotBeRead) {
  ModbusDevice device(kTcp, [](const Request& request) -> std::vector<Reply> {
    if (request.unit == 2) return {};
    if (request.first == 50) return {exception(request, 2)};
    return {answer(request, register_number)};
  });
  Given given = over_tcp(device);
  add_word(given, "silent", 1, 2);
  add_word(given, "good", 6);
  add_word(given, "refused", 50);
  const auto results = probe(driver_table(), *given.settings());
  ASSERT_EQ(results.size(), 3U);
  EXPECT_EQ(results.at(0).error, "station 2: no answer within 0.1 s");
  EXPECT_EQ(results.at(1).error, "");
  EXPECT_EQ(results.at(1).raw, 6.0);
  EXPECT_GT(results.at(1).latency_ns, 0);
  EXPECT_NE(results.at(2).error.find("exception 2"), std::string::npos);
  device.leave();
  for (const auto& [channel, result] : probe(driver_table(), *given.settings()))
    EXPECT_NE(result.error.find("Connection refused"), std::string::npos);
}

}  // namespace
}  // namespace dwell::test
