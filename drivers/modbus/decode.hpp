// Values from 16-bit registers, and back (the way back serves tests and simulators).
//
// A value of the bytes A B C D (A the most significant) travels as `abcd` when the first register holds AB and the
// second CD; `cdab` has the registers the other way round, `badc` the bytes within each register, `dcba` both. 64-bit
// values do the same with four registers; 16-bit ones have no registers to swap, so that only the bytes' order matters
// to them.
#pragma once

#include <bit>
#include <cstdint>

namespace dwell::modbus {

enum class Type : std::uint8_t { int16, uint16, int32, uint32, float32, float64 };
enum class Order : std::uint8_t { abcd, cdab, badc, dcba };

// Registers that one value takes.
[[nodiscard]] constexpr unsigned registers_of(Type type) noexcept {
  switch (type) {
    case Type::int16:
    case Type::uint16:
      return 1;
    case Type::int32:
    case Type::uint32:
    case Type::float32:
      return 2;
    case Type::float64:
      return 4;
  }
  return 1;
}

namespace detail {

constexpr std::uint16_t swapped(std::uint16_t word) noexcept {
  return static_cast<std::uint16_t>((word << 8U) | (word >> 8U));
}
constexpr bool reverses_registers(Order order) noexcept { return order == Order::cdab || order == Order::dcba; }
constexpr bool swaps_bytes(Order order) noexcept { return order == Order::badc || order == Order::dcba; }

}  // namespace detail

// The value at `registers` (registers_of(type) of them). Exact; NaN or infinite where the device sent that.
[[nodiscard]] inline double decode(const std::uint16_t* registers, Type type, Order order) noexcept {
  const unsigned count = registers_of(type);
  std::uint64_t bits = 0;
  for (unsigned i = 0; i < count; ++i) {
    const std::uint16_t word = registers[detail::reverses_registers(order) ? count - 1 - i : i];
    bits = (bits << 16U) | (detail::swaps_bytes(order) ? detail::swapped(word) : word);
  }
  switch (type) {
    case Type::int16:
      return static_cast<std::int16_t>(bits);
    case Type::uint16:
      return static_cast<std::uint16_t>(bits);
    case Type::int32:
      return static_cast<std::int32_t>(bits);
    case Type::uint32:
      return static_cast<std::uint32_t>(bits);
    case Type::float32:
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    case Type::float64:
      return std::bit_cast<double>(bits);
  }
  return 0.0;
}

// The registers for a value that the type can hold exactly.
inline void encode(double value, Type type, Order order, std::uint16_t* registers) noexcept {
  std::uint64_t bits = 0;
  switch (type) {
    case Type::int16:
    case Type::uint16:
    case Type::int32:
    case Type::uint32:
      bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
      break;
    case Type::float32:
      bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
      break;
    case Type::float64:
      bits = std::bit_cast<std::uint64_t>(value);
      break;
  }
  const unsigned count = registers_of(type);
  for (unsigned i = 0; i < count; ++i) {
    const auto word = static_cast<std::uint16_t>(bits >> (16U * (count - 1 - i)));
    registers[detail::reverses_registers(order) ? count - 1 - i : i] =
        detail::swaps_bytes(order) ? detail::swapped(word) : word;
  }
}

}  // namespace dwell::modbus
