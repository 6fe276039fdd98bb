// What a Modbus TCP client may say, and what it is answered.
#include "daemon/serve/modbus_conversation.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace dwell {
namespace {

using Turn = ModbusConversation::Turn;
using Bytes = std::vector<std::uint8_t>;

// Registers 0 … 199, each holding its own address plus 0x1000.
struct ModbusConversationTest : testing::Test {
  ModbusConversationTest() {
    for (std::uint16_t i = 0; i < 200; ++i) registers.push_back(static_cast<std::uint16_t>(0x1000 + i));
  }
  // Hands over byte after byte; what the last of them led to.
  Turn say(const Bytes& bytes) {
    Turn turn = Turn::more;
    for (const std::uint8_t byte : bytes) {
      EXPECT_EQ(turn, Turn::more) << "bytes behind the end";
      conversation.room()[0] = byte;
      turn = conversation.received(1, [this](std::uint16_t first, std::uint16_t count) {
        asked.push_back({first, count});
        return first + count <= 200 ? std::span<const std::uint16_t>(registers).subspan(first, count)
                                    : std::span<const std::uint16_t>();
      });
    }
    return turn;
  }
  [[nodiscard]] Bytes answer() const { return {conversation.answer().begin(), conversation.answer().end()}; }

  std::vector<std::uint16_t> registers;
  std::vector<std::pair<int, int>> asked;
  ModbusConversation conversation;
};

TEST_F(ModbusConversationTest, BothTablesReadTheSameRegistersAndTheHeaderComesBack) {
  EXPECT_EQ(say({0xab, 0xcd, 0, 0, 0, 6, 17, 4, 0, 5, 0, 2}), Turn::answer);
  EXPECT_EQ(answer(), (Bytes{0xab, 0xcd, 0, 0, 0, 7, 17, 4, 4, 0x10, 0x05, 0x10, 0x06}));
  EXPECT_EQ(say({0, 1, 0, 0, 0, 6, 255, 3, 0, 5, 0, 1}), Turn::answer) << "the next request";
  EXPECT_EQ(answer(), (Bytes{0, 1, 0, 0, 0, 5, 255, 3, 2, 0x10, 0x05}));
}

TEST_F(ModbusConversationTest, AnAnswerHolds125RegistersAtMost) {
  EXPECT_EQ(say({0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 125}), Turn::answer);
  EXPECT_EQ(answer().size(), 259U);
  EXPECT_EQ(answer()[8], 250);
  asked.clear();
  EXPECT_EQ(say({0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 126}), Turn::refused);
  EXPECT_EQ(answer(), (Bytes{0, 1, 0, 0, 0, 3, 1, 0x84, 3}));
  EXPECT_EQ(say({0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 0}), Turn::refused);
  EXPECT_EQ(answer()[8], 3);
  EXPECT_TRUE(asked.empty());
}

TEST_F(ModbusConversationTest, RegistersThatDoNotExistAreAnIllegalAddress) {
  EXPECT_EQ(say({0, 1, 0, 0, 0, 6, 1, 3, 0, 199, 0, 2}), Turn::refused);
  EXPECT_EQ(answer(), (Bytes{0, 1, 0, 0, 0, 3, 1, 0x83, 2}));
}

TEST_F(ModbusConversationTest, WhatWritesIsAnIllegalFunction) {
  for (const std::uint8_t function : Bytes{0, 1, 2, 5, 6, 15, 16, 22, 23, 43, 0x84}) {
    EXPECT_EQ(say({0, 1, 0, 0, 0, 6, 1, function, 0, 0, 0, 1}), Turn::refused) << int{function};
    EXPECT_EQ(answer(), (Bytes{0, 1, 0, 0, 0, 3, 1, static_cast<std::uint8_t>(function | 0x80), 1}));
  }
  EXPECT_TRUE(asked.empty());
}

TEST_F(ModbusConversationTest, ARequestOfAnotherLengthIsAnIllegalValue) {
  EXPECT_EQ(say({0, 1, 0, 0, 0, 2, 1, 4}), Turn::refused);
  EXPECT_EQ(answer()[8], 3);
  EXPECT_EQ(say({0, 1, 0, 0, 0, 7, 1, 4, 0, 0, 0, 1, 9}), Turn::refused);
  EXPECT_EQ(answer()[8], 3);
}

TEST_F(ModbusConversationTest, TheLongestRequestIsReadWhole) {
  Bytes request{0, 1, 0, 0, 0, 254, 1, 16};
  request.resize(260);
  EXPECT_EQ(say(request), Turn::refused);
  EXPECT_FALSE(conversation.under_way());
}

TEST_F(ModbusConversationTest, WhatIsNoModbusTcpIsBroken) {
  EXPECT_EQ(say({'G', 'E', 'T', ' ', '/', ' ', 'H'}), Turn::broken);
  conversation = {};
  EXPECT_EQ(say({0, 1, 0, 0, 0, 1, 1}), Turn::broken) << "too short for a function";
  conversation = {};
  EXPECT_EQ(say({0, 1, 0, 0, 0, 255, 1}), Turn::broken) << "longer than a request may be";
  conversation = {};
  EXPECT_EQ(say({0, 1, 0, 0, 1, 6, 1}), Turn::broken);
}

TEST_F(ModbusConversationTest, AsksForNoByteBeyondTheRequest) {
  EXPECT_EQ(conversation.room().size(), 7U);
  say({0, 1, 0, 0, 0, 6, 1});
  EXPECT_EQ(conversation.room().size(), 5U);
  EXPECT_TRUE(conversation.under_way());
  say({4, 0, 0, 0, 1});
  EXPECT_EQ(conversation.room().size(), 7U);
}

}  // namespace
}  // namespace dwell
