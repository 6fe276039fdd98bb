#include "drivers/modbus/decode.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace dwell::modbus {
namespace {

constexpr std::array kOrders = {Order::abcd, Order::cdab, Order::badc, Order::dcba};

using Registers = std::vector<std::uint16_t>;

// What libmodbus's manual and device manuals print: the bytes of 123456.0f are 47 F1 20 00.
TEST(ModbusDecode, ReadsAFloatInEveryOrder) {
  EXPECT_EQ(decode(Registers{0x47F1, 0x2000}.data(), Type::float32, Order::abcd), 123456.0);
  EXPECT_EQ(decode(Registers{0x2000, 0x47F1}.data(), Type::float32, Order::cdab), 123456.0);
  EXPECT_EQ(decode(Registers{0xF147, 0x0020}.data(), Type::float32, Order::badc), 123456.0);
  EXPECT_EQ(decode(Registers{0x0020, 0xF147}.data(), Type::float32, Order::dcba), 123456.0);
}

// -2.5 as a double is C0 04 00 …; 0x0102030405060708 shows where every byte goes.
TEST(ModbusDecode, ReadsADoubleInEveryOrder) {
  EXPECT_EQ(decode(Registers{0xC004, 0, 0, 0}.data(), Type::float64, Order::abcd), -2.5);
  const double value = std::bit_cast<double>(std::uint64_t{0x0102030405060708});
  EXPECT_EQ(decode(Registers{0x0102, 0x0304, 0x0506, 0x0708}.data(), Type::float64, Order::abcd), value);
  EXPECT_EQ(decode(Registers{0x0708, 0x0506, 0x0304, 0x0102}.data(), Type::float64, Order::cdab), value);
  EXPECT_EQ(decode(Registers{0x0201, 0x0403, 0x0605, 0x0807}.data(), Type::float64, Order::badc), value);
  EXPECT_EQ(decode(Registers{0x0807, 0x0605, 0x0403, 0x0201}.data(), Type::float64, Order::dcba), value);
}

TEST(ModbusDecode, ReadsIntegersInEveryOrder) {
  EXPECT_EQ(decode(Registers{0xFFFE, 0x1DC0}.data(), Type::int32, Order::abcd), -123456.0);
  EXPECT_EQ(decode(Registers{0x1DC0, 0xFFFE}.data(), Type::int32, Order::cdab), -123456.0);
  EXPECT_EQ(decode(Registers{0xFEFF, 0xC01D}.data(), Type::int32, Order::badc), -123456.0);
  EXPECT_EQ(decode(Registers{0xC01D, 0xFEFF}.data(), Type::int32, Order::dcba), -123456.0);
  EXPECT_EQ(decode(Registers{0xFFFF, 0xFFFF}.data(), Type::uint32, Order::abcd), 4294967295.0);
}

TEST(ModbusDecode, ReadsEveryWordAsInt16AndUint16InEveryOrder) {
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    const auto swapped = static_cast<std::uint16_t>((word << 8U) | (word >> 8U));
    for (const Order order : kOrders) {
      const std::uint16_t sent =
          order == Order::badc || order == Order::dcba ? swapped : static_cast<std::uint16_t>(word);
      ASSERT_EQ(decode(&sent, Type::uint16, order), word);
      ASSERT_EQ(decode(&sent, Type::int16, order), word < 0x8000 ? static_cast<double>(word) : word - 65536.0);
    }
  }
}

TEST(ModbusDecode, HandsOnWhatIsNotFinite) {
  EXPECT_TRUE(std::isnan(decode(Registers{0x7FC0, 0}.data(), Type::float32, Order::abcd)));
  EXPECT_EQ(decode(Registers{0xFF80, 0}.data(), Type::float32, Order::abcd), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(decode(Registers{0x7FF8, 0, 0, 0}.data(), Type::float64, Order::abcd)));
}

template <class T>
void expect_round_trip(T value, Type type) {
  for (const Order order : kOrders) {
    std::array<std::uint16_t, 4> registers{};
    encode(static_cast<double>(value), type, order, registers.data());
    RC_ASSERT(decode(registers.data(), type, order) == static_cast<double>(value));
  }
}

RC_GTEST_PROP(ModbusDecode, ReturnsEveryIntegerThatWasEncoded, (std::int32_t wide, std::uint32_t positive)) {
  expect_round_trip(static_cast<std::int16_t>(wide), Type::int16);
  expect_round_trip(static_cast<std::uint16_t>(wide), Type::uint16);
  expect_round_trip(wide, Type::int32);
  expect_round_trip(positive, Type::uint32);
}

RC_GTEST_PROP(ModbusDecode, ReturnsEveryFloatThatWasEncoded, (std::uint32_t single_bits, std::uint64_t double_bits)) {
  const auto single = std::bit_cast<float>(single_bits);
  const auto twice = std::bit_cast<double>(double_bits);
  if (std::isfinite(single)) expect_round_trip(single, Type::float32);
  if (std::isfinite(twice)) expect_round_trip(twice, Type::float64);
}

}  // namespace
}  // namespace dwell::modbus
