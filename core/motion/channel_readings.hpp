// Groups the readings of a motion by channel, and leaves readings out.
#pragma once

#include <cstddef>
#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// Per channel, the indexes of its readings in data.readings, in their order. channels: of the rig. O(readings);
// allocates; thread-safe.
[[nodiscard]] inline std::vector<std::vector<std::size_t>> by_channel(std::size_t channels, const MotionData& data) {
  std::vector<std::vector<std::size_t>> out(channels);
  for (std::size_t i = 0; i < data.readings.size(); ++i)
    out[static_cast<std::size_t>(data.readings[i].channel)].push_back(i);
  return out;
}

// Takes out the readings that are marked; marked: one for each. Returns how many. O(readings).
inline std::size_t leave_out(const std::vector<bool>& marked, MotionData& data) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < marked.size(); ++i)
    if (!marked[i]) data.readings[kept++] = data.readings[i];
  data.readings.resize(kept);
  return marked.size() - kept;
}

}  // namespace dwell
