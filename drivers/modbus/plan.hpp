// Which registers are read together: neighbours of one station and table in one transaction, up to a maximum, and never
// a value torn over two transactions, since its halves would be of two instants. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/modbus/decode.hpp"

namespace dwell::modbus {

enum class Table : std::uint8_t { holding = 3, input = 4 };  // the function code that reads it

// What one channel wants.
struct Reading {
  std::uint16_t index = 0;  // dwell_sample::channel
  std::uint8_t station = 1;
  Table table = Table::input;
  std::uint16_t first = 0;  // register
  Type type = Type::int16;
  Order order = Order::abcd;
  [[nodiscard]] unsigned end() const noexcept { return first + registers_of(type); }
};

// One transaction.
struct Block {
  std::uint8_t station = 1;
  Table table = Table::input;
  std::uint16_t first = 0;
  std::uint16_t count = 0;        // registers
  std::vector<Reading> readings;  // all of them within [first, first + count)
  [[nodiscard]] unsigned end() const noexcept { return static_cast<unsigned>(first) + count; }
};

inline constexpr unsigned kMaxRegisters = 125;  // of one transaction, by the protocol

// Blocks ordered by station, table and register. max_registers: 4 … kMaxRegisters (a float64 takes 4). Overlapping
// readings share their registers; between readings that are not neighbours nothing is read.
[[nodiscard]] std::vector<Block> plan(std::vector<Reading> readings, unsigned max_registers);

}  // namespace dwell::modbus
