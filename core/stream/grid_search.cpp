#include "core/stream/grid_search.hpp"

#include <algorithm>

namespace dwell {

std::optional<ArrivalGrid> GridSearch::add(std::int64_t arrival_ns) noexcept {
  if (pause_ > 0) {
    --pause_;
    return std::nullopt;
  }
  stretch_[count_++] = arrival_ns;
  if (count_ != kShortStretch && count_ != kLongestStretch) return std::nullopt;
  // No attempt amid a bunch after a stall. Its arrivals are given out as stamps, later than the clock's next.
  const std::size_t n = count_;
  if (4 * (stretch_[n - 1] - stretch_[n - 2]) * static_cast<std::int64_t>(n) < stretch_[n - 1] - stretch_[0]) {
    if (n == kLongestStretch) std::copy(stretch_.begin() + 1, stretch_.begin() + (count_--), stretch_.begin());
    return std::nullopt;
  }
  // A stated rate far from the mean one is dropped: it may be that of several streams of the device together.
  const double mean_ns = static_cast<double>(stretch_[n - 1] - stretch_[0]) / static_cast<double>(n - 1);
  if (mean_ns < 0.9 * nominal_ns_ || mean_ns > 1.5 * nominal_ns_) nominal_ns_ = 0.0;
  auto grid = find_grid({stretch_.data(), n}, nominal_ns_);
  if (grid) {
    next_pause_ = kLongestStretch;
  } else if (n == kLongestStretch) {
    nominal_ns_ = 0.0;  // perhaps the failure's cause
    count_ = 0;
    pause_ = next_pause_;
    next_pause_ = std::min(2 * next_pause_, kLongestPause);
  }
  return grid;
}

}  // namespace dwell
