// Gains of the readings in their order. Where scans come in a pattern that repeats, the gains become steady after some
// hundred scans and are used again from then on: a pass then costs the means alone, about a tenth.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/motion/covariance_filter.hpp"
#include "core/motion/interval_steps.hpp"

namespace dwell {

class GainSchedule {
 public:
  // What to do with a reading: move on by `step` (null: not at all), then take it with `gain`. dt_ns: the interval of
  // `step`; may differ from the one asked for by kSameInterval_ns, which the caller makes good at the next.
  struct Due {
    const Step* step;
    const KalmanGain* gain;
    std::int64_t dt_ns;
  };

  // All must outlive it.
  GainSchedule(CovarianceFilter& filter, IntervalSteps& steps) : filter_(filter), steps_(steps) {}

  // dt_ns >= 0: since the last reading. Valid until the next call.
  [[nodiscard]] Due next(std::int64_t dt_ns, int channel, int stretch);

 private:
  struct Slot {
    std::int64_t dt_ns = 0;
    int channel = -1, stretch = -1;
    KalmanGain gain;
  };
  [[nodiscard]] static bool same_place(const Slot& slot, std::int64_t dt_ns, int channel, int stretch) noexcept;
  [[nodiscard]] bool steady(const KalmanGain& before, const KalmanGain& now);
  void run(std::int64_t dt_ns, int channel, int stretch, KalmanGain& out);
  void thaw();

  CovarianceFilter& filter_;
  IntervalSteps& steps_;
  std::vector<Slot> cycle_;  // one scan: from a reading of one channel to the next of the same
  std::size_t at_ = 0;       // the slot of the next reading
  bool repeats_ = false;     // all slots of this cycle so far are as in the last
  bool frozen_ = false;
  KalmanGain now_;
  Eigen::VectorXd largest_dK_;  // per parameter, seen so far: what a change of dK is held against
};

}  // namespace dwell
