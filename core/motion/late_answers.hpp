// Readings whose instants are too uncertain to count in an estimate: a device was asked and answered late, so the
// reading may be of any instant in between. The likelihood takes an instant as it stands. Left in, one answer that was
// held up for a tenth of the drive's period leaves no estimate.
//
// The rule is that of the motion gate once it knows the noise (core/intake/motion_gate.hpp), for a stretch that is
// known as a whole: the median half width of a channel tells which answers were held up, and the readings about such an
// answer tell the slope. Where the noise is not known, only what is late by far goes out, and only while it is rare.
#pragma once

#include <cstddef>
#include <vector>

#include "core/motion/likelihood.hpp"

namespace dwell {

// Takes out every reading with a half width beyond 1.5 medians of its channel's that either moves the reading, by the
// steepest slope about it, by more than √6 standard deviations of the noise or of the rounding, or is beyond five
// medians while such answers are rare. data: by time. noise: per channel, SI, as local_noise() gives it; NaN: not
// known. Returns how many. O(n log n); allocates.
std::size_t leave_out_late(const std::vector<double>& noise, MotionData& data);

}  // namespace dwell
