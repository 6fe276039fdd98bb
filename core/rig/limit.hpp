// Whether coefficients lie within the limits of the rig file. ISO 14253-1 decides by the uncertainty: a number is good
// or bad only if its whole 95 % interval is.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

enum class LimitVerdict : std::uint8_t {
  none,       // there is no number, or none that may be relied on
  kept,       // value ± U95 is wholly within
  undecided,  // value ± U95 contains a limit
  violated,   // value ± U95 is wholly outside
};
[[nodiscard]] const char* to_string(LimitVerdict verdict) noexcept;  // "none", "kept", …

struct JudgedLimit {
  int element = 1;
  CoefficientKind kind = CoefficientKind::stiffness;
  Bounds bounds;  // SI
  LimitVerdict verdict = LimitVerdict::none;
  std::string reason;    // why there is no verdict; empty: there is one
  bool doubted = false;  // `reason` is kDoubtedNumber followed by a doubt
};
inline constexpr const char* kDoubtedNumber = "the number must not be relied on";

// Whether a dwell has this element's coefficients, and a doubt says not to rely on them; null: it does not.
[[nodiscard]] const Doubt* doubt_of(const Dwell& dwell, int element) noexcept;

// The verdict on one number; none: its value or uncertainty is not finite.
[[nodiscard]] LimitVerdict judge_limit(const Bounds& bounds, const Coefficient& coefficient) noexcept;

// Every limit of the rig against the dwell's coefficients, in the order of the rig file, stiffness first. A coefficient
// that must not be relied on has no verdict. Thread-safe; allocates.
[[nodiscard]] std::vector<JudgedLimit> judge_limits(const Rig& rig, const Dwell& dwell);

// The same for the current dwell. Unless it is being measured, no limit has a verdict; the reason is the dwell's state,
// or what judge_limits() says already. Whether the dwell is stale is the caller's to judge. Thread-safe; allocates.
[[nodiscard]] std::vector<JudgedLimit> judge_limits_now(const Rig& rig, const Dwell& current);

}  // namespace dwell
