// The register map: every station (unit id) serves the same channels, each in another type and word order.
//
//   station = 1 + 4 · type + order,  type float32 0, float64 1, int32 2, uint32 3, int16 4, uint16 5
//                                    order abcd 0, cdab 1, badc 2, dcba 3
//
// so 1 is float32 abcd, 2 float32 cdab, 5 float64 abcd, 24 uint16 dcba. Channel i (0 the table, 1 … n the masses, last
// the ground force of a clamped chain) begins at register i · words, words being 2, 4, 2, 2, 1, 1; the input and the
// holding table are the same. Floats are m (or mm) and N. Integers count 1 nm and 1 mN (32 bit) or 1 µm and 0.1 N (16
// bit), the unsigned ones from the middle of their range, and saturate. abcd: most significant byte first; cdab: words
// reversed; badc: bytes within each word reversed; dcba: both.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace rigsim {

enum class Type : std::uint8_t { float32, float64, int32, uint32, int16, uint16 };
enum class Order : std::uint8_t { abcd, cdab, badc, dcba };

inline constexpr int kStations = 24;

struct Station {
  Type type = Type::float32;
  Order order = Order::abcd;

  [[nodiscard]] int words() const noexcept;
  [[nodiscard]] bool floating() const noexcept { return type <= Type::float64; }
  // Of the integer types: SI per count, and the count of zero.
  [[nodiscard]] double step(bool force) const noexcept;
  [[nodiscard]] double bias() const noexcept;
};

// The station of a unit id; none: there is no such station.
[[nodiscard]] std::optional<Station> station(int unit) noexcept;

// Writes the registers (words() of them) of one value; floats multiplied by float_scale. NaN becomes the lowest code of
// an integer type.
void encode(double si, bool force, double float_scale, Station station, std::span<std::uint16_t> registers) noexcept;

}  // namespace rigsim
