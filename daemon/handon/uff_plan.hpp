// Plans a universal file: for each channel its even step and its stretches without gaps. Needs a pass over the stream
// before anything is written, since each dataset states its length first.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/handon/selection.hpp"

namespace dwell::handon {

// Readings without a gap longer than Resampler::kGap usual intervals, and the even instants among them.
struct EvenRun {
  std::int64_t begin_ns = 0;  // its first reading, on the clock that recorded
  std::int64_t first_ns = 0;  // first even instant: a multiple of the step from the run's zero
  std::int64_t count = 0;     // of even instants, > 0
};

struct EvenChannel {
  double interval_ns = 0.0;  // the median time between readings; 0: too few readings
  std::int64_t step_ns = 0;
  std::vector<EvenRun> stretches;
  std::uint64_t readings = 0;
  std::uint64_t left_out = 0;  // readings of stretches that are too short: fewer than Resampler::kFewest
};

// One plan per channel of the rig. All measuring channels share the step of the fastest; auxiliary channels have their
// own. Fails if a channel has too many gaps.
[[nodiscard]] Result<std::vector<EvenChannel>> plan_even(Selection& selection, const Progress& progress);

// The step for an interval: the largest of 1, 2, 2.5, 4, 5, 8 times a power of ten of nanoseconds that is at most 2 %
// longer. Exact in the six digits that the format gives it.
[[nodiscard]] std::int64_t even_step_ns(double interval_ns);
// The first multiple of the step at or after t_ns that six significant digits hold exactly in seconds. Both relative to
// the run's zero.
[[nodiscard]] std::int64_t even_start_ns(std::int64_t t_ns, std::int64_t step_ns);

// Finds where stretches begin; the plan and the writing pass must agree on it.
class GapFinder {
 public:
  // true: this reading begins a stretch.
  bool begins(std::int64_t t_ns, double interval_ns) noexcept;

 private:
  std::int64_t last_ns_ = INT64_MIN;
};

}  // namespace dwell::handon
