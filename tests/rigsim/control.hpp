// Control lines: one verb and its arguments, answered by "ok", "ok …" or "error: …". The same lines come from standard
// input, the control socket, Server::command and a recording's script. The manual (rigsim(1)) lists them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/rigsim/device.hpp"

namespace rigsim {

inline constexpr std::size_t kLongestLine = 256;

[[nodiscard]] std::vector<std::string> split_words(std::string_view line);

// Executes what concerns the device and its faults at simulated time t. None: a verb that is not one of these.
[[nodiscard]] std::optional<std::string> execute(Device& device, double t_s, const std::vector<std::string>& words);

}  // namespace rigsim
