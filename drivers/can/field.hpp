// Where a signal lies in a frame's data and how its bits are a number. Pure; no allocation.
//
// Bit b of the data is bit b % 8 (0 the least significant) of byte b / 8. An Intel signal begins with its least
// significant bit at `start` and goes up; a Motorola signal begins with its most significant bit at `start` and goes
// down to bit 0 of that byte, then on from bit 7 of the next: as DBC files count it.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace dwell::can {

enum class Order : std::uint8_t { intel, motorola };
enum class Form : std::uint8_t { unsigned_integer, signed_integer, float32, float64 };

struct Field {
  std::uint16_t start = 0;
  std::uint8_t length = 1;  // bits, 1 … 64; float32: 32, float64: 64
  Order order = Order::intel;
  Form form = Form::unsigned_integer;
};

inline constexpr unsigned kLongestField = 64;
inline constexpr std::size_t kMostBytes = 64;  // of a CAN FD frame

// The most significant bit of a Motorola field when bits are counted from the first byte's bit 7 on.
[[nodiscard]] constexpr unsigned motorola_first(const Field& field) noexcept {
  return field.start / 8U * 8U + (7U - field.start % 8U);
}
// How many bytes of data the field needs.
[[nodiscard]] constexpr std::size_t bytes_of(const Field& field) noexcept {
  const unsigned first = field.order == Order::intel ? field.start : motorola_first(field);
  return (std::size_t{first} + field.length - 1) / 8 + 1;
}

// The field's bits; `data` has at least bytes_of(field) bytes.
[[nodiscard]] constexpr std::uint64_t bits_of(const std::uint8_t* data, const Field& field) noexcept {
  std::uint64_t bits = 0;
  if (field.order == Order::intel) {
    const std::size_t end = bytes_of(field);
    std::size_t byte = field.start / 8U;
    bits = std::uint64_t{data[byte]} >> field.start % 8U;
    for (unsigned at = 8U - field.start % 8U; ++byte < end; at += 8) bits |= std::uint64_t{data[byte]} << at;
  } else {
    const unsigned first = motorola_first(field);
    unsigned left = field.length;  // bits still to come
    std::size_t byte = first / 8;
    unsigned here = 8 - first % 8;  // of them in this byte
    while (left > 0) {
      const unsigned take = left < here ? left : here;
      bits = (bits << (take % 64)) | ((std::uint64_t{data[byte]} >> (here - take)) & ((1U << take) - 1U));
      left -= take;
      here = 8;
      ++byte;
    }
  }
  return field.length == 64 ? bits : bits & ((std::uint64_t{1} << field.length) - 1);
}

// The number that the bits are; a float may be none. Integers of more than 53 bits are rounded.
[[nodiscard]] inline double number_of(std::uint64_t bits, const Field& field) noexcept {
  switch (field.form) {
    case Form::signed_integer: {
      const unsigned unused = 64U - field.length;
      return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
    }
    case Form::float32:
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    case Form::float64:
      return std::bit_cast<double>(bits);
    default:
      return static_cast<double>(bits);
  }
}

}  // namespace dwell::can
