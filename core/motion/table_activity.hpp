// How the table moves: when it begins to, and in which stretches its motion is of one kind, so that one intensity fits.
//
// Judged by the range of a channel that shows the table within half a period of the nominal drive: that is amplitude
// for a sine of any phase, and it grows with whatever else the table does. No such channel: one stretch.
#pragma once

#include <cstdint>
#include <vector>

#include "core/motion/likelihood.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

struct TableActivity {
  bool seen = false;          // some channel shows the table
  bool moves = false;         // by more than Excitation::minimum, and by more than noise may
  int channel = -1;           // the channel judged by
  std::int64_t onset_ns = 0;  // where it begins to
  double amplitude = 0.0;     // m, the largest
  double scatter = 0.0;       // standard deviation from reading to reading, over the largest amplitude; 0: not known
  // From when on the table moves with this amplitude, m.
  struct AmplitudeFrom {
    std::int64_t from_ns;
    double amplitude;
  };
  std::vector<AmplitudeFrom> amplitudes;  // by time; the last one holds to the end
};

// The channel by which the activity is judged; -1: no channel shows the table.
[[nodiscard]] int activity_channel(const Rig& rig);
// Half a period of the nominal drive.
[[nodiscard]] std::int64_t half_period_ns(const Rig& rig);
// The amplitude of that channel's readings, SI, up to which the table is at rest: Excitation::minimum times ω, ω² for a
// velocity, an acceleration. table_activity() takes a larger one where the noise asks for it.
[[nodiscard]] double least_amplitude(const Rig& rig, int channel);

// Largest TableActivity::scatter of a table that moves. 200 readings of noise alone span 5.5 standard deviations, so
// that one of them over half the span is 0.36; 0.25 is a span of eight. The cubic misses part of a sine: read five
// times a period it has 0.24 … 0.25, read six times 0.13 … 0.15. With half the limit the latter would pass for noise.
// Without the limit, beside noise of 0.8 … 1.8 times the table's amplitude, seven of 32 sound rigs had a coefficient
// 4 … 9 u off.
inline constexpr double kScatterOfNoise = 0.25;

// data: by time. noise: per channel, SI. Allocates; thread-safe. O(readings), and O(m log m) of m half periods.
[[nodiscard]] TableActivity table_activity(const Rig& rig, const MotionData& data, const std::vector<double>& noise);

// Standard deviation of the noise from reading to reading, per channel: what a cubic through four neighbours leaves
// over, by its median. Includes what the cubic misses of a motion sampled coarsely. NaN below 8 readings.
[[nodiscard]] std::vector<double> local_noise(const Rig& rig, const MotionData& data);

// Takes out readings that are far from their four neighbours, where they are few: left in, one of 100 σ would decide
// all. Returns how many.
std::size_t leave_out_spikes(const Rig& rig, MotionData& data);

}  // namespace dwell
