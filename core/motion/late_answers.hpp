// Leaves out readings whose instants are too uncertain for an estimate.
//
// A device that answers late may have read its transducer at any instant since it was asked. The stamp stands in the
// middle, and the likelihood takes it as exact. One answer that was held up for a tenth of the drive's period leaves no
// estimate.
//
// The motion gate has the same rule for a live channel (core/intake/motion_gate.hpp). Here the stretch is known as a
// whole. So the usual half width is the channel's median, and the slope is taken from the readings on both sides. If
// the noise of a channel is not known, only answers that are late by far go out, and only while they are rare.
#pragma once

#include <cstddef>
#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// Takes out readings whose half width exceeds 1.5 medians of their channel, and either five medians, while such are
// rare, or √6 σ over the steepest slope about the reading. σ: of the noise, or of the rounding if that is larger. data:
// by time. noise: per channel, SI, as local_noise() gives it; NaN: not known. Returns how many. O(n log n); allocates.
std::size_t leave_out_late(const std::vector<double>& noise, MotionData& data);

}  // namespace dwell
