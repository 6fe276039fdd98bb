#include "drivers/modbus/plan.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <map>

namespace dwell::modbus {
namespace {

Reading at(unsigned first, Type type, std::uint8_t station = 1, Table table = Table::input) {
  return {static_cast<std::uint16_t>(first), station, table, static_cast<std::uint16_t>(first), type, Order::abcd};
}

TEST(ModbusPlan, ReadsNeighboursInOneTransaction) {
  const auto blocks = plan({at(4, Type::int16), at(0, Type::float32), at(2, Type::float32)}, 125);
  ASSERT_EQ(blocks.size(), 1U);
  EXPECT_EQ(blocks[0].first, 0);
  EXPECT_EQ(blocks[0].count, 5);
  EXPECT_EQ(blocks[0].readings.size(), 3U);
}

TEST(ModbusPlan, ReadsNothingBetweenValuesThatAreApart) {
  const auto blocks = plan({at(0, Type::float32), at(3, Type::float32)}, 125);
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[0].count, 2);
  EXPECT_EQ(blocks[1].first, 3);
}

TEST(ModbusPlan, KeepsStationsAndTablesApart) {
  const auto blocks = plan({at(0, Type::int16), at(1, Type::int16, 2), at(1, Type::int16, 1, Table::holding)}, 125);
  EXPECT_EQ(blocks.size(), 3U);
}

TEST(ModbusPlan, SplitsAtTheMaximumWithoutTearingAValue) {
  const auto blocks = plan({at(0, Type::float32), at(2, Type::float32), at(4, Type::float32)}, 5);
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[0].count, 4);
  EXPECT_EQ(blocks[1].first, 4);
  EXPECT_EQ(blocks[1].count, 2);
}

TEST(ModbusPlan, SharesRegistersThatTwoChannelsRead) {
  const auto blocks = plan({at(0, Type::uint32), at(0, Type::uint16), at(1, Type::uint16)}, 125);
  ASSERT_EQ(blocks.size(), 1U);
  EXPECT_EQ(blocks[0].count, 2);
}

TEST(ModbusPlan, ReachesTheLastRegister) {
  const auto blocks = plan({at(65532, Type::float64)}, 125);
  ASSERT_EQ(blocks.size(), 1U);
  EXPECT_EQ(blocks[0].end(), 65536U);
}

RC_GTEST_PROP(ModbusPlan, ReadsEveryValueWholeExactlyOnceWithinTheMaximum, ()) {
  const auto max_registers = *rc::gen::inRange<unsigned>(4, kMaxRegisters + 1);
  std::vector<Reading> readings;
  const auto count = *rc::gen::inRange<std::size_t>(0, 200);
  for (std::size_t i = 0; i < count; ++i) {
    Reading reading;
    reading.index = static_cast<std::uint16_t>(i);
    reading.station = *rc::gen::inRange<std::uint8_t>(1, 3);
    reading.table = *rc::gen::element(Table::holding, Table::input);
    reading.type = *rc::gen::element(Type::int16, Type::uint32, Type::float32, Type::float64);
    reading.first = *rc::gen::inRange<std::uint16_t>(0, 300);
    readings.push_back(reading);
  }
  std::map<std::uint16_t, int> planned;
  for (const Block& block : plan(readings, max_registers)) {
    RC_ASSERT(block.count >= 1U && block.count <= max_registers);
    std::vector<bool> wanted(block.count);
    for (const Reading& reading : block.readings) {
      RC_ASSERT(reading.station == block.station && reading.table == block.table);
      RC_ASSERT(reading.first >= block.first && reading.end() <= block.end());
      for (unsigned r = reading.first; r < reading.end(); ++r) wanted[r - block.first] = true;
      ++planned[reading.index];
    }
    RC_ASSERT(std::count(wanted.begin(), wanted.end(), false) == 0);
  }
  RC_ASSERT(planned.size() == count);
  for (const auto& [channel, times] : planned) RC_ASSERT(times == 1);
}

}  // namespace
}  // namespace dwell::modbus
