// How much of a channel's noise comes from its instants. A reading that is off by τ in time is off by v τ in value, v
// being the velocity of what is read. In the steady motion at ω such noise is largest where the reading crosses zero.
// In a transient it is larger or smaller than in the steady motion, as the velocity is. Noise of the values is the same
// everywhere. So the variance of reading i is, with σ² that of the steady motion and m the part due to instants,
//
//   σ_i² = σ² (1 - m + m s_i),   s_i = v_i² / mean of v² in the steady motion
//
// m is the slope of the squared residuals of the steady motion over s_i (its variance by H. White, Econometrica 48
// (1980) 817, which takes no distribution for granted). Nothing here rests on the model of the chain.
#pragma once

#include <vector>

namespace dwell {

struct ChannelReadings;

struct TimingNoise {
  double part = 0.0;              // m, 0 … 1
  double u = 0.0;                 // standard uncertainty of m
  double steady_velocity2 = 0.0;  // mean of v² in the steady motion, reading's unit squared per s²; 0: m is not known

  // σ_i/σ of each reading; all 1 if m is 0. O(readings), allocates.
  [[nodiscard]] std::vector<double> relative_to_steady(const ChannelReadings& readings) const;
  // Mean of s_i over the readings; 1 if m is not known. O(readings), allocates.
  [[nodiscard]] double mean_square_velocity(const ChannelReadings& readings) const;
};

// steady: readings of steady motion at omega, rad/s, in order of time. Its harmonics up to `harmonics` are fitted. With
// fewer than 8 readings for each unknown of that fit m is not known, and 0. O(readings · harmonics²), allocates.
[[nodiscard]] TimingNoise timing_noise_of(const ChannelReadings& steady, double omega, int harmonics);

}  // namespace dwell
