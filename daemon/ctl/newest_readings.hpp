// Keeps the newest readings of a replay. An entry of a run file names a stretch of them by its length.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/instants.hpp"
#include "core/motion/hold_record.hpp"

namespace dwell::ctl {

// Bound to one thread. Memory: 24 bytes for each reading of the largest stretch.
class NewestReadings {
 public:
  // published: entries with a member `of.given`, the length of their stretch.
  template <class Published>
  explicit NewestReadings(const std::vector<Published>& published) : ring_(largest(published)) {}

  void push(const HoldRecord::Reading& reading) noexcept { ring_.push(reading); }
  // The newest `given` of them, in their order; all, if there are fewer. Allocates; O(readings).
  [[nodiscard]] std::vector<HoldRecord::Reading> newest(std::size_t given) const {
    std::vector<HoldRecord::Reading> readings = ring_.readings();
    const std::size_t older = readings.size() - std::min(given, readings.size());
    readings.erase(readings.begin(), readings.begin() + static_cast<std::ptrdiff_t>(older));
    return readings;
  }

 private:
  template <class Published>
  static std::size_t largest(const std::vector<Published>& published) {
    std::size_t most = 1;
    for (const Published& one : published) most = std::max(most, one.of.given);
    return most;
  }

  HoldRecord ring_;
};

// States in `of` how many readings there are, and the instants of the first and the last, s on the run's axis.
template <class Of>
void state_stretch(const std::vector<HoldRecord::Reading>& readings, Of& of) {
  of.given = readings.size();
  if (readings.empty()) return;
  of.from_s = to_s(readings.front().t_ns);
  of.until_s = to_s(readings.back().t_ns);
}

}  // namespace dwell::ctl
