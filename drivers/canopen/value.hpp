// The data types of measured objects, and their values out of a PDO's bits.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace dwell::canopen {

enum class Kind : std::uint8_t { signed_integer, unsigned_integer, real };

struct Type {
  Kind kind = Kind::signed_integer;
  std::uint8_t bits = 32;  // integers: 8, 16, 24, 32, 64; reals: 32, 64

  friend bool operator==(const Type&, const Type&) = default;
};

// "integer32", "unsigned16", "real32"
[[nodiscard]] std::string to_string(const Type& type);
[[nodiscard]] std::optional<Type> parse_type(std::string_view name) noexcept;
// Of the objects that device profiles define as measured values: CiA 404 (6100h, 6130h, 7100h …) and CiA 406 (6004h,
// 6020h, 6030h); none: another object.
[[nodiscard]] std::optional<Type> profile_type(std::uint16_t index) noexcept;
inline constexpr const char* kTypeNames =
    "integer8|integer16|integer24|integer32|integer64|unsigned8|unsigned16|unsigned24|unsigned32|unsigned64|real32|"
    "real64";

// The value that begins at a bit, the least significant of byte 0 being bit 0. None: the data end before it, or it is a
// real that is no finite number.
enum class Verdict : std::uint8_t { value, short_frame, invalid };
struct Reading {
  Verdict verdict = Verdict::invalid;
  double value = 0.0;
};
[[nodiscard]] Reading read_value(std::span<const std::uint8_t> data, unsigned first_bit, const Type& type) noexcept;

}  // namespace dwell::canopen
