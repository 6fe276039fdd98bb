// The readings that a verification rests on: a stretch of motion that the coefficients were not fitted to. It begins
// with the time that the initial state is estimated from; what comes after is scored.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/timing_noise.hpp"
#include "core/verify/virtual_test.hpp"

namespace dwell {

// Readings of one channel that count, SI, in order of time.
struct ChannelReadings {
  Instants t_ns;
  std::vector<double> value;
};

struct VerificationStretch {
  std::string fault;                      // why there is none; empty: there is one
  int table = -1;                         // the channel that shows the table's motion
  std::vector<int> compared;              // the channels that are predicted
  std::vector<ChannelReadings> readings;  // per channel of the rig, less the mean of the dwell; empty: not used
  std::vector<double> sigma;              // per channel of the rig, of one reading of the steady motion, SI
  std::vector<TimingNoise> timing;        // per channel of the rig
  std::int64_t score_from_ns = 0, until_ns = 0;
  double omega = 0.0;  // of the drive, rad/s

  // Leaves out the compared channels for which keep(c) is false.
  template <class Keep>
  void compare_only(const Keep& keep) {
    std::erase_if(compared, [&keep](int c) { return !keep(c); });
  }
  // Of channel c, how many readings come before those that are scored.
  [[nodiscard]] std::size_t unscored(int c) const;
  // Of all compared channels together.
  [[nodiscard]] std::size_t scored() const;
};

// The transient before `dwell`, whose coefficients are those of `chain`. before: per channel of the rig the readings
// from the end of the dwell before it on, on the axis of the dwell's times (s · 1e9). Of what was read after settled_s
// a few readings of the table are used, and some thousand readings of each channel for its timing noise. Allocates.
[[nodiscard]] VerificationStretch transient_before(const Rig& rig, const Dwell& dwell, const Chain& chain,
                                                   const std::vector<ChannelReadings>& before);

// The motion of another dwell, whose readings the coefficients of `chain` never used: its transient, and steady_s of
// the steady motion after it. readings: as `before`, but to the end of that dwell. Allocates.
[[nodiscard]] VerificationStretch motion_of(const Rig& rig, const Dwell& other, const Chain& chain,
                                            const std::vector<ChannelReadings>& readings, double steady_s);

}  // namespace dwell
