// clang-format off
#include <utility>
// clang-format on

#include "daemon/serve/listener.hpp"

#include <gtest/gtest.h>

#include <boost/asio/ip/tcp.hpp>
#include <optional>
#include <stdexcept>

#include "tests/daemon/sockets.hpp"

namespace dwell {
namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;

struct ListenerTest : testing::Test {
  ListenerTest() {
    Tcp::acceptor& acceptor = listener->acceptor();
    const Tcp::endpoint any(asio::ip::address_v4::loopback(), 0);
    acceptor.open(any.protocol());
    acceptor.bind(any);
    boost::system::error_code error;
    listener->begin([this](Tcp::socket socket) { welcome(std::move(socket)); }, error);
    EXPECT_FALSE(error) << error.message();
    port = acceptor.local_endpoint().port();
    thread.emplace(loop);
  }
  ~ListenerTest() override { thread.reset(); }
  // Says which client it is; the second one is bad luck.
  void welcome(Tcp::socket socket) {
    if (++came == 2) throw std::runtime_error("no memory");
    boost::system::error_code ignored;
    socket.write_some(asio::buffer(std::to_string(came) + "\n"), ignored);
  }

  EventLoop loop;
  std::optional<Listener<Tcp>> listener{std::in_place, loop};
  std::uint16_t port = 0;
  int came = 0;
  std::optional<test::LoopThread> thread;
};

TEST_F(ListenerTest, WhatBefallsOneClientKeepsNoOtherOut) {
  EXPECT_EQ(test::Client::tcp(port).until("\n"), "1\n");
  test::Client::tcp(port).until("\n");
  EXPECT_EQ(test::Client::tcp(port).until("\n"), "3\n");
}

TEST_F(ListenerTest, NobodyIsWelcomedOnceItIsClosed) {
  EXPECT_EQ(test::Client::tcp(port).until("\n"), "1\n");
  thread->on_loop([this] {
    listener.reset();
    return 0;
  });
  EXPECT_FALSE(test::Client::tcp(port).connected());
}

}  // namespace
}  // namespace dwell
