// The one complex type for phasors, dynamic stiffnesses and poles.
#pragma once

#include <complex>

namespace dwell {

using Complex = std::complex<double>;

}  // namespace dwell
