// The median of numbers that are at hand. Running medians: core/intake.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dwell {

// Of an even number of them the upper one of the middle two. At least one; none is NaN. O(n); thread-safe.
template <class Number>
[[nodiscard]] Number median(std::vector<Number> of) {
  const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
  std::nth_element(of.begin(), middle, of.end());
  return *middle;
}

}  // namespace dwell
