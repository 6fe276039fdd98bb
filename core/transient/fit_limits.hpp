// Limits that the fits of modes share: of their steps, their samples and their work.
#pragma once

namespace dwell {

// A step that raised the misfit is retried with kShorter of it, kShortened times. If that does not help, it leads to
// another optimum.
inline constexpr double kShorter = 0.3;
inline constexpr int kShortened = 2;
inline constexpr double kConverged = 0.1;     // a shorter step ends the refinement, in standard deviations of a pole
inline constexpr double kPerParameter = 4.0;  // samples of a channel per linear parameter, at least
inline constexpr double kOfLine = 6.0;        // multiplications of a line at a sample
inline constexpr double kSamePole = 0.1;      // relative distance below which two poles are the same
inline constexpr double kHighestSearched = 12.0;  // multiples of the drive's ω up to which a pole is searched

}  // namespace dwell
