// A stored dwell against the same dwell computed again, member by member of the JSON object.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "core/result/dwell.hpp"

namespace dwell::ctl {

// The tolerance for a replay by another build, libm or set of CPU features: this part of the number's standard
// uncertainty. A number without uncertainty may change by this part of itself, a share of a budget by this part of the
// whole, an instant by one microsecond. The sources of a budget may change their order.
inline constexpr double kReplayTolerance = 1e-3;
inline constexpr double kInstantTolerance_s = 1e-6;

struct Difference {
  std::string what;              // "elements[1].stiffness.value"
  std::string stored, replayed;  // as JSON; empty: there is no such member
  // |replayed - stored| in standard uncertainties of that number; NaN: it has none, or is no number.
  double in_u = kNaN;
  bool tolerable = false;  // a number, within the tolerance for another build
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
