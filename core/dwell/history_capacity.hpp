// How many samples a pipeline keeps of a hold.
#pragma once

#include <algorithm>
#include <cstddef>

namespace dwell {

// For a rig of so many channels: 32768 samples a channel, half a million in all at most.
[[nodiscard]] inline std::size_t history_capacity(int channels) {
  return std::min<std::size_t>(std::size_t{1} << 19, static_cast<std::size_t>(channels) << 15);
}

}  // namespace dwell
