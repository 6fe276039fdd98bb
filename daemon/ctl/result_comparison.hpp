// A stored dwell against the same dwell computed again, member by member of the JSON object.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "core/result/dwell.hpp"

namespace dwell::ctl {

// What another build, libm or set of CPU features may change: a part of the standard uncertainty of each number. Of a
// number without uncertainty the same part of itself; of a share of a budget the same part of the whole, whatever the
// order of the sources; of an instant one microsecond.
inline constexpr double kReplayTolerance = 1e-3;
inline constexpr double kInstantTolerance_s = 1e-6;

struct Difference {
  std::string what;              // "elements[1].stiffness.value"
  std::string stored, replayed;  // as JSON; empty: there is no such member
  // |replayed - stored| in standard uncertainties of that number; NaN: it has none, or is no number.
  double in_u = kNaN;
  bool tolerable = false;  // a number, off by no more than what another build may change
};

struct Comparison {
  std::uint64_t numbers = 0;  // compared
  std::vector<Difference> differences;
};

// Numbers are compared bit for bit, all else as it stands; the members must be the same, in any order. Nothing is left
// out. Fails where one of the two is not a JSON object.
[[nodiscard]] tl::expected<Comparison, std::string> compare_results(std::string_view stored, std::string_view replayed);

// The numbers in the text of a JSON document.
[[nodiscard]] std::uint64_t numbers_in(std::string_view json) noexcept;

}  // namespace dwell::ctl
