// Brings an interface's own stamps, counted by an oscillator of its own, onto CLOCK_MONOTONIC_RAW. Pure.
//
// Every frame also carries the kernel's stamp, which is later than the interface's by the way through the bus (USB,
// SPI) and the interrupt: never less than some shortest time, and often just that. So the line below all differences of
// the two gives rate and offset; the shortest time itself cannot be told from the offset and stays in, constant and
// common to all channels of the interface. Differences are taken at their least of each second, the line through the
// last 16.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace dwell::socketcan {

class HardwareClock {
 public:
  // hardware_ns: the interface's stamp; kernel_ns: the kernel's on CLOCK_MONOTONIC_RAW, none if that is of no use. The
  // instant on CLOCK_MONOTONIC_RAW; none: not known yet, or the interface's clock contradicts the kernel's.
  [[nodiscard]] std::optional<std::int64_t> map(std::int64_t hardware_ns,
                                                std::optional<std::int64_t> kernel_ns) noexcept;
  void reset() noexcept { *this = HardwareClock(); }

 private:
  struct Point {
    std::int64_t x_ns = 0;  // hardware
    std::int64_t d_ns = 0;  // kernel less hardware
  };
  static constexpr std::size_t kWindows = 16;

  void begin(const Point& point) noexcept;
  void close_window() noexcept;
  [[nodiscard]] std::int64_t line_ns(std::int64_t x_ns) const noexcept;

  bool begun_ = false;
  std::array<Point, kWindows> least_{};
  std::size_t count_ = 0, next_ = 0;
  std::int64_t window_ns_ = 0;  // begin of the current one
  Point window_{};              // the least of the current one
  bool window_empty_ = true;
  std::int64_t last_ns_ = 0;
  Point anchor_{};  // of the line
  double slope_ = 0.0;
};

}  // namespace dwell::socketcan
