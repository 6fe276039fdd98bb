// The outlet for PLCs as foreign programs read it: mbpoll (libmodbus) and pymodbus, both from Debian.
#include "daemon/outlets/plc.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <optional>

#include "daemon/serve/event_loop.hpp"
#include "tests/daemon/measured_service.hpp"
#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

struct PlcTest : testing::Test, test::MeasuredService {
  PlcTest() {
    auto made = Plc::make(loop, {});
    EXPECT_TRUE(made) << made.error().message;
    plc = std::move(*made);
    thread.emplace(loop);
  }
  ~PlcTest() override { thread.reset(); }
  void show() {
    thread->on_loop([this] {
      plc->show(view());
      return 0;
    });
  }
  [[nodiscard]] std::string port() const { return std::to_string(plc->server().port()); }
  // Its exit code and what it says.
  static std::pair<int, std::string> run(const std::string& command) {
    FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
    std::string text;
    std::array<char, 4096> part{};
    while (std::fgets(part.data(), part.size(), pipe) != nullptr) text += part.data();
    return {pclose(pipe), text};
  }

  EventLoop loop;
  std::unique_ptr<Plc> plc;
  std::optional<test::LoopThread> thread;
};

TEST_F(PlcTest, MbpollReadsTheFirstElement) {
  show();
  const auto [code, text] = run("mbpoll -m tcp -p " + port() + " -0 -1 -t 3:float -B -r 26 -c 4 127.0.0.1");
  EXPECT_EQ(code, 0) << text;
  EXPECT_NE(text.find("[26]: \t24010\n"), std::string::npos) << text;
  EXPECT_NE(text.find("[28]: \t27.4\n"), std::string::npos) << text;
  EXPECT_NE(text.find("[30]: \t60.2\n"), std::string::npos) << text;
  const auto holding = run("mbpoll -m tcp -p " + port() + " -0 -1 -t 4 -r 3 -c 1 127.0.0.1").second;
  EXPECT_NE(holding.find("[3]: \t2\n"), std::string::npos) << holding;
}

TEST_F(PlcTest, MbpollCannotWrite) {
  show();
  const auto [code, text] = run("mbpoll -m tcp -p " + port() + " -0 -1 -t 4 -r 0 127.0.0.1 7");
  EXPECT_NE(text.find("Illegal function"), std::string::npos) << text;
}

// Python's client reads every page of a chain of 64 masses.
TEST_F(PlcTest, PymodbusReadsEveryPage) {
  chain_of(64);
  rig.limits = {{12, Bounds{0.0, 10.0}, Bounds{0.0, 120.0}}};
  verify(Verdict::adequate);
  show();
  const auto [code, text] =
      run(std::string(DWELL_PYTHON) + " " DWELL_SOURCE "/tests/daemon/read_registers.py " + port());
  EXPECT_EQ(code, 0) << text;
}

TEST_F(PlcTest, BeforeAnythingIsKnownThereAreNoRegisters) {
  test::Client client = test::Client::tcp(plc->server().port());
  client.send({"\x00\x01\x00\x00\x00\x06\x01\x04\x00\x00\x00\x01", 12});
  EXPECT_EQ(client.exactly(9).substr(7), "\x84\x02");
}

TEST_F(PlcTest, EachImageHasAGenerationOfItsOwn) {
  test::Client client = test::Client::tcp(plc->server().port());
  for (const char generation : std::string("\1\2\3")) {
    show();
    client.send({"\x00\x01\x00\x00\x00\x06\x01\x04\x00\x00\x00\x01", 12});
    EXPECT_EQ(client.exactly(11)[10], generation);
  }
}

}  // namespace
}  // namespace dwell
