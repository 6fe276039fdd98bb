#include "tests/rigsim/stations.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace rigsim {
namespace {

std::uint64_t integer_bits(double counts, double lowest, double highest) noexcept {
  const double kept = std::isnan(counts) ? lowest : std::clamp(std::nearbyint(counts), lowest, highest);
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(kept));
}

}  // namespace

int Station::words() const noexcept {
  switch (type) {
    case Type::float64:
      return 4;
    case Type::int16:
    case Type::uint16:
      return 1;
    default:
      return 2;
  }
}

double Station::step(bool force) const noexcept {
  const bool wide = type == Type::int32 || type == Type::uint32;
  if (force) return wide ? 1e-3 : 0.1;
  return wide ? 1e-9 : 1e-6;
}

double Station::bias() const noexcept {
  if (type == Type::uint32) return 2147483648.0;
  if (type == Type::uint16) return 32768.0;
  return 0.0;
}

std::optional<Station> station(int unit) noexcept {
  if (unit < 1 || unit > kStations) return std::nullopt;
  return Station{static_cast<Type>((unit - 1) / 4), static_cast<Order>((unit - 1) % 4)};
}

void encode(double si, bool force, double float_scale, Station station, std::span<std::uint16_t> registers) noexcept {
  std::uint64_t bits = 0;
  const double counts = si / station.step(force) + station.bias();
  switch (station.type) {
    case Type::float32:
      bits = std::bit_cast<std::uint32_t>(static_cast<float>(si * float_scale));
      break;
    case Type::float64:
      bits = std::bit_cast<std::uint64_t>(si * float_scale);
      break;
    case Type::int32:
      bits = integer_bits(counts, -2147483648.0, 2147483647.0);
      break;
    case Type::uint32:
      bits = integer_bits(counts, 0.0, 4294967295.0);
      break;
    case Type::int16:
      bits = integer_bits(counts, -32768.0, 32767.0);
      break;
    case Type::uint16:
      bits = integer_bits(counts, 0.0, 65535.0);
      break;
  }
  const auto words = static_cast<std::size_t>(station.words());
  const bool words_reversed = station.order == Order::cdab || station.order == Order::dcba;
  const bool bytes_reversed = station.order == Order::badc || station.order == Order::dcba;
  for (std::size_t i = 0; i < words && i < registers.size(); ++i) {
    const std::size_t from_low = words_reversed ? i : words - 1 - i;
    auto word = static_cast<std::uint16_t>(bits >> (16 * from_low));
    if (bytes_reversed) word = static_cast<std::uint16_t>((word << 8) | (word >> 8));
    registers[i] = word;
  }
}

}  // namespace rigsim
