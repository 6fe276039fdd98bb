// The Modbus server on its sockets: hostile clients cost neither the others nor the service anything that is not
// counted.
#include "daemon/serve/modbus_server.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "daemon/serve/awaited_address.hpp"
#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

using namespace std::string_literals;
using test::Client;

// One register each, of unit 1; its answer is 11 bytes.
const std::string kRequest = "\x00\x01\x00\x00\x00\x06\x01\x04\x00\x00\x00\x01"s;
const std::string kAnswer = "\x00\x01\x00\x00\x00\x05\x01\x04\x02\x12\x34"s;

struct ModbusServerTest : testing::Test {
  void begin() {
    auto made = ModbusServer::make(loop, options, [this](std::uint16_t, std::uint16_t count) {
      return std::span<const std::uint16_t>(registers).first(count);
    });
    ASSERT_TRUE(made) << made.error().message;
    server = std::move(*made);
    thread.emplace(loop);
  }
  void TearDown() override {
    thread.reset();
    server.reset();
  }
  [[nodiscard]] Client connect() const { return Client::tcp(server->port()); }
  ModbusStats stats() {
    return thread->on_loop([this] { return server->stats(); });
  }
  static std::string ask(Client& client) {
    client.send(kRequest);
    return client.exactly(kAnswer.size());
  }

  const std::vector<std::uint16_t> registers = std::vector<std::uint16_t>(125, 0x1234);
  EventLoop loop;
  ModbusOptions options;
  std::unique_ptr<ModbusServer> server;
  std::optional<test::LoopThread> thread;
};

TEST_F(ModbusServerTest, AnswersRequestAfterRequest) {
  begin();
  Client client = connect();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(ask(client), kAnswer);
  EXPECT_EQ(stats().answers, 3U);
  EXPECT_EQ(stats().clients, 1U);
}

TEST_F(ModbusServerTest, RequestsSentAheadAreAnsweredInTheirOrder) {
  begin();
  Client client = connect();
  client.send(kRequest + "\x00\x02\x00\x00\x00\x06\x01\x06\x00\x00\x00\x01"s + kRequest.substr(0, 5));
  EXPECT_EQ(client.exactly(kAnswer.size()), kAnswer);
  EXPECT_EQ(client.exactly(9), "\x00\x02\x00\x00\x00\x03\x01\x86\x01"s);
  client.send(kRequest.substr(5));
  EXPECT_EQ(client.exactly(kAnswer.size()), kAnswer);
  EXPECT_EQ(stats().exceptions, 1U);
}

TEST_F(ModbusServerTest, WhatIsNoModbusIsClosedAndCounted) {
  begin();
  Client client = connect();
  client.send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(client.all(), "");
  EXPECT_EQ(stats().malformed, 1U);
  EXPECT_EQ(stats().clients, 0U);
}

TEST_F(ModbusServerTest, HalfARequestIsClosedInTimeAndCounted) {
  options.request_time = std::chrono::milliseconds(20);
  begin();
  Client half = connect();
  half.send(kRequest.substr(0, 9));
  EXPECT_EQ(half.all(), "");
  EXPECT_EQ(stats().timed_out, 1U);
}

TEST_F(ModbusServerTest, WhoSaysNothingIsClosedInTime) {
  options.idle_time = std::chrono::milliseconds(20);
  begin();
  Client silent = connect();
  EXPECT_EQ(silent.all(), "");
  EXPECT_EQ(stats().timed_out, 1U);
}

// The loop was busy until after the end of the idle time. Request and end are then found at once.
TEST_F(ModbusServerTest, ARequestThatCameInTimeIsAnsweredHoweverLateItIsRead) {
  options.idle_time = std::chrono::seconds(1);  // enough to connect and to ask again on a machine that is busy
  begin();
  Client client = connect();
  while (stats().clients == 0) std::this_thread::yield();
  thread->on_loop([&] {
    client.send(kRequest);
    const auto end = std::chrono::steady_clock::now() + options.idle_time;
    while (std::chrono::steady_clock::now() < end) std::this_thread::yield();
  });
  EXPECT_EQ(client.exactly(kAnswer.size()), kAnswer);
  EXPECT_EQ(ask(client), kAnswer);
  EXPECT_EQ(stats().timed_out, 0U);
}

// Requests without end for all that an answer can hold, and none is read: the kernel's buffers fill, and then nothing
// more is taken from it.
TEST_F(ModbusServerTest, WhoReadsNoAnswerIsClosedAndTheOthersAreServedMeanwhile) {
  options.request_time = std::chrono::milliseconds(200);
  options.pause = std::chrono::milliseconds(0);
  begin();
  Client deaf = Client::tcp(server->port(), 1024);
  std::string many;
  for (int i = 0; i < 4096; ++i) many += kRequest.substr(0, 11) + "\x7d";
  std::thread flood([&] {
    while (deaf.send(many)) {
    }
  });
  Client other = connect();
  for (int i = 0; i < 20; ++i) EXPECT_EQ(ask(other), kAnswer);
  flood.join();
  EXPECT_EQ(stats().timed_out, 1U);
}

TEST_F(ModbusServerTest, WhoIsServedKeepsItsPlaceAgainstAnyNumberOfOthers) {
  options.clients = 4;
  begin();
  Client plc = connect();
  EXPECT_EQ(ask(plc), kAnswer);
  std::vector<Client> others;
  for (int i = 0; i < 40; ++i) others.push_back(connect());
  Client panel = connect();
  EXPECT_EQ(ask(panel), kAnswer) << "a newcomer takes the place of one that never asked";
  EXPECT_EQ(ask(plc), kAnswer);
  EXPECT_LE(stats().clients, 4U);
  EXPECT_GE(stats().displaced, 30U);
}

TEST_F(ModbusServerTest, WhereAllAreServedANewOneIsRefused) {
  options.clients = 2;
  begin();
  Client one_client = connect(), two = connect();
  EXPECT_EQ(ask(one_client), kAnswer);
  EXPECT_EQ(ask(two), kAnswer);
  Client late = connect();
  EXPECT_EQ(late.all(), "");
  EXPECT_EQ(stats().refused, 1U);
  EXPECT_EQ(ask(two), kAnswer);
}

TEST_F(ModbusServerTest, WhoHasNotAskedForLongMakesRoom) {
  options.clients = 1;
  options.kept_time = std::chrono::milliseconds(0);
  begin();
  Client old = connect();
  EXPECT_EQ(ask(old), kAnswer);
  Client young = connect();
  EXPECT_EQ(ask(young), kAnswer);
  EXPECT_EQ(stats().displaced, 1U);
}

// 192.0.2.0/24 is for documentation (RFC 5737): no computer has it.
TEST_F(ModbusServerTest, AnAddressThatIsNotThereYetIsAwaited) {
  options.host = "192.0.2.7";
  begin();
  EXPECT_TRUE(stats().awaits_address);
  AwaitedAddress local("127.0.0.1", true), foreign("192.0.2.7", true), never_missed("192.0.2.7", false);
  EXPECT_FALSE(local.awaited()) << "it has come";
  EXPECT_TRUE(foreign.awaited());
  EXPECT_FALSE(never_missed.awaited());
}

TEST_F(ModbusServerTest, AnAddressInUseIsSaid) {
  begin();
  EventLoop another;
  ModbusOptions same = options;
  same.port = server->port();
  const auto made = ModbusServer::make(another, same, {});
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("cannot listen on 127.0.0.1:" + std::to_string(same.port)), std::string::npos);
  same.host = "bench";
  const auto named = ModbusServer::make(another, same, {});
  ASSERT_FALSE(named);
  EXPECT_TRUE(named.error().bad_address);
}

}  // namespace
}  // namespace dwell
