// The seam between GPIO as the service uses it and the kernel: single lines, by their level as the rig file means it
// (active_low is dealt with below this). KernelLines is the real thing, tests bring lines of their own. Bound to one
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "config/rig_file.hpp"

namespace dwell::gpio {

struct LineEdge {
  std::int64_t t_ns = 0;  // CLOCK_MONOTONIC, the kernel's
  bool level = false;     // after it
  bool gap = false;       // edges before this one were lost
};

enum class Edges : std::uint8_t { rising, both };

class InputLine {
 public:
  virtual ~InputLine() = default;
  // Polls readable when edges wait.
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
  // The level now.
  virtual tl::expected<bool, std::string> level() = 0;
  // Edges in the order of their instants, at most `room`; 0: none wait. Never blocks.
  virtual tl::expected<std::size_t, std::string> take(LineEdge* out, std::size_t room) = 0;
};

class OutputLine {
 public:
  virtual ~OutputLine() = default;
  virtual tl::expected<void, std::string> set(bool level) = 0;
};

class LineSource {
 public:
  virtual ~LineSource() = default;
  // Both fail with the reason in words: no such chip, no such line, in use by whom.
  virtual tl::expected<std::unique_ptr<InputLine>, std::string> input(const config::GpioLine& line, Edges edges) = 0;
  virtual tl::expected<std::unique_ptr<OutputLine>, std::string> output(const config::GpioLine& line, bool level) = 0;
};

}  // namespace dwell::gpio
