// Figures of a predicted against a measured series of one channel, p_i against m_i, i = 1 … N:
//
// - error: rms(p - m) / rms(m), the comparison error of ASME V&V 20-2009, 1-5, as a part of the rms;
// - fit: 100 (1 - ‖p - m‖ / ‖m - mean(m)‖) % (L. Ljung, System Identification, 2nd ed., 16.5);
// - magnitude M = √(Σp² / Σm²) - 1, phase P = arccos(Σpm / √(Σp² Σm²)) / π, combined C = √(M² + P²) (M. A. Sprague and
//   T. L. Geers, Commun. Numer. Methods Eng. 20 (2004) 467-487): a delay is told apart from a wrong gain;
// - E_n = √mean((p - m)²) / (2 √mean(u²(p - m))), ISO/IEC 17043, B.4.1, of a time series.
//
// Pure functions, thread-safe, O(N).
#pragma once

#include <Eigen/Core>

#include "core/result/verification.hpp"

namespace dwell {

// Root of the mean square; 0 of none.
[[nodiscard]] double rms(const Eigen::Ref<const Eigen::VectorXd>& series);

// samples, rms, error, fit and Sprague-Geers; all else is as it was. Of equal length, SI; measured is about 0.
void compare(const Eigen::Ref<const Eigen::VectorXd>& predicted, const Eigen::Ref<const Eigen::VectorXd>& measured,
             ChannelComparison& out);

}  // namespace dwell
