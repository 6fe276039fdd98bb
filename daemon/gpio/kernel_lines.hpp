// The lines of real chips, over libgpiod: kernel_lines_1.cpp for its 1.6, kernel_lines_2.cpp for 2.x, which is another
// interface altogether; the build takes the one that fits. Edge stamps are CLOCK_MONOTONIC, taken in the interrupt
// (Linux 5.7 and later). Debouncing is not left to the kernel: it stamps a debounced edge when the time is over, on the
// next tick of its timer, which is milliseconds off.
#pragma once

#include "daemon/gpio/line.hpp"

namespace dwell::gpio {

class KernelLines : public LineSource {
 public:
  tl::expected<std::unique_ptr<InputLine>, std::string> input(const config::GpioLine& line, Edges edges) override;
  tl::expected<std::unique_ptr<OutputLine>, std::string> output(const config::GpioLine& line, bool level) override;
};

// What went wrong with a line, from errno; `holder`: who uses the line, empty: not known.
[[nodiscard]] std::string line_fault(const config::GpioLine& line, int error, const std::string& holder);
// Whether edges wait at the descriptor; an error when the chip behind it has gone.
[[nodiscard]] tl::expected<bool, std::string> edges_wait(int descriptor);

inline constexpr const char* kConsumer = "dwelld";
inline constexpr std::size_t kKernelQueue = 16;  // edges that the kernel keeps per line

}  // namespace dwell::gpio
