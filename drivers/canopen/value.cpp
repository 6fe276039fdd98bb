#include "drivers/canopen/value.hpp"

#include <bit>
#include <cmath>

namespace dwell::canopen {
namespace {

struct Named {
  std::string_view name;
  Type type;
};
constexpr Named kTypes[] = {
    {"integer8", {Kind::signed_integer, 8}},
    {"integer16", {Kind::signed_integer, 16}},
    {"integer24", {Kind::signed_integer, 24}},
    {"integer32", {Kind::signed_integer, 32}},
    {"integer64", {Kind::signed_integer, 64}},
    {"unsigned8", {Kind::unsigned_integer, 8}},
    {"unsigned16", {Kind::unsigned_integer, 16}},
    {"unsigned24", {Kind::unsigned_integer, 24}},
    {"unsigned32", {Kind::unsigned_integer, 32}},
    {"unsigned64", {Kind::unsigned_integer, 64}},
    {"real32", {Kind::real, 32}},
    {"real64", {Kind::real, 64}},
};

}  // namespace

std::string to_string(const Type& type) {
  for (const Named& each : kTypes)
    if (each.type == type) return std::string(each.name);
  return {};
}

std::optional<Type> parse_type(std::string_view name) noexcept {
  for (const Named& each : kTypes)
    if (each.name == name) return each.type;
  return std::nullopt;
}

std::optional<Type> profile_type(std::uint16_t index) noexcept {
  switch (index) {
    case 0x6100:  // CiA 404: input and process values, once per data type
    case 0x6130:
      return Type{Kind::real, 32};
    case 0x7100:
    case 0x7130:
    case 0x6030:  // CiA 406: speed
      return Type{Kind::signed_integer, 16};
    case 0x8100:
    case 0x8130:
      return Type{Kind::signed_integer, 24};
    case 0x9100:
    case 0x9130:
    case 0x6004:  // CiA 406: position
    case 0x6020:
      return Type{Kind::signed_integer, 32};
    default:
      return std::nullopt;
  }
}

Reading read_value(std::span<const std::uint8_t> data, unsigned first_bit, const Type& type) noexcept {
  if (first_bit + type.bits > 8 * data.size()) return {Verdict::short_frame, 0.0};
  std::uint64_t raw = 0;
  for (unsigned i = 0; i < type.bits; ++i) {
    const unsigned bit = first_bit + i;
    raw |= std::uint64_t{data[bit / 8] >> bit % 8 & 1U} << i;
  }
  double value = 0.0;
  switch (type.kind) {
    case Kind::signed_integer: {
      const unsigned unused = 64U - type.bits;
      value = static_cast<double>(static_cast<std::int64_t>(raw << unused) >> unused);
      break;
    }
    case Kind::unsigned_integer:
      value = static_cast<double>(raw);
      break;
    case Kind::real:
      value = type.bits == 32 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)))
                              : std::bit_cast<double>(raw);
      if (!std::isfinite(value)) return {Verdict::invalid, 0.0};
      break;
  }
  return {Verdict::value, value};
}

}  // namespace dwell::canopen
