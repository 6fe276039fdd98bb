// The object `motion` of the public interface, and the same as people read it.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/result/motion.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell {

// A motion with what its numbers need to be read.
struct MotionView {
  Motion motion = Motion::translation;
  std::vector<ChannelLabel> channels;
  MotionEstimate estimate;
  std::optional<Agreement> agreement;  // with the dwell of the same data; nullopt: nothing to compare
  // Of a live dwell: stamps of the first and the last reading that the estimate was given, and how many there were.
  double from_s = kNaN, until_s = kNaN;
  std::size_t given = 0;
};

[[nodiscard]] MotionView make_view(const MotionEstimate& estimate, const std::optional<Agreement>& agreement,
                                   const Rig& rig);

// "contradict these: the stiffness of element 2 differs by 2.5 of the joint U of both".
[[nodiscard]] std::string verdict_on(const Agreement& agreement);

// A line "any motion · …", the coefficients, and the warnings; or why there are none.
[[nodiscard]] std::string motion_text(const MotionView& view);

}  // namespace dwell
