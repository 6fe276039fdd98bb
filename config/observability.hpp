// Which places of the chain move in a way that no combination of transducers gives.
#pragma once

#include <optional>
#include <vector>

namespace dwell::config {

// A transducer of motion: y_at, or y_at - y_relative_to. Places are 0 (the table) … masses.
struct Transducer {
  int at = 0;
  std::optional<int> relative_to;
};

// The places 0 … masses whose motion is not determined, in order. A place is determined if an absolute transducer sits
// there, or one across to a place that is. Transducers at places outside the chain count for nothing.
// Cost O(masses + transducers).
[[nodiscard]] std::vector<int> undetermined_places(int masses, const std::vector<Transducer>& transducers);

}  // namespace dwell::config
