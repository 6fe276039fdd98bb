// The service's control socket: one JSON object per line there and back. Bound to one thread; blocks until the answer
// is there or the time has passed.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace dwell::ctl {

struct ControlLimits {
  std::chrono::milliseconds time{30'000};  // for the whole exchange; a check waits for every device
  std::size_t line_bytes = 16 * 1024 * 1024;
};

// Sends one line (without its end), returns the answer's (without its end). The error names the socket and the reason.
[[nodiscard]] tl::expected<std::string, std::string> control_exchange(const std::string& path, std::string_view line,
                                                                      const ControlLimits& limits = {});

}  // namespace dwell::ctl
