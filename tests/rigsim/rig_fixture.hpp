// A simulated rig in the test's own process, whose clock stands still unless the test moves it.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "tests/rigsim/client.hpp"
#include "tests/rigsim/server.hpp"

namespace rigsim::test {

inline constexpr int kChannels = 5;                                 // of the default rig: y0 … y3, reaction
inline constexpr double kFull[] = {0.005, 0.01, 0.01, 0.01, 50.0};  // their sizes

inline void await(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  while (!condition()) {
    ASSERT_LT(std::chrono::steady_clock::now(), end);
    std::this_thread::yield();
  }
}

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

}  // namespace rigsim::test
