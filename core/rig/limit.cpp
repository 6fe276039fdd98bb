#include "core/rig/limit.hpp"

#include <cmath>

namespace dwell {
namespace {

// Why no number of this element is judged; empty: it is.
std::string obstacle(const Dwell& dwell, const ElementEstimate* element, const Doubt* doubt) {
  if (!std::isfinite(dwell.settled_s) || element == nullptr) return "not settled";
  if (!element->identifiable) return element->reason.empty() ? "not identifiable" : element->reason;
  return doubt != nullptr ? kDoubtedNumber + (": " + doubt->what) : "";
}

// Why nothing is measured now; empty: a dwell is.
std::string why_not_measured(State state) {
  if (state == State::measuring) return {};
  if (state == State::complete) return "the dwell has ended";
  if (state == State::fault) return "the data do not suffice";
  return "not settled";
}

}  // namespace

const char* to_string(LimitVerdict verdict) noexcept {
  switch (verdict) {
    case LimitVerdict::none:
      return "none";
    case LimitVerdict::kept:
      return "kept";
    case LimitVerdict::undecided:
      return "undecided";
    case LimitVerdict::violated:
      return "violated";
  }
  return "unknown";
}

const Doubt* doubt_of(const Dwell& dwell, int element) noexcept {
  const ElementEstimate* const estimate = element_of(dwell, element);
  if (!std::isfinite(dwell.settled_s) || estimate == nullptr || !estimate->identifiable) return nullptr;
  for (const Doubt& doubt : dwell.doubts)
    if (concerns(doubt, element)) return &doubt;
  return nullptr;
}

LimitVerdict judge_limit(const Bounds& bounds, const Coefficient& coefficient) noexcept {
  const double low = coefficient.value - coefficient.U95;
  const double high = coefficient.value + coefficient.U95;
  if (!std::isfinite(low) || !std::isfinite(high)) return LimitVerdict::none;
  if (low >= bounds.low && high <= bounds.high) return LimitVerdict::kept;
  if (high < bounds.low || low > bounds.high) return LimitVerdict::violated;
  return LimitVerdict::undecided;
}

std::vector<JudgedLimit> judge_limits(const Rig& rig, const Dwell& dwell) {
  std::vector<JudgedLimit> judged;
  for (const Limit& limit : rig.limits) {
    const ElementEstimate* const element = element_of(dwell, limit.element);
    const Doubt* const doubt = doubt_of(dwell, limit.element);
    const std::string why = obstacle(dwell, element, doubt);
    const auto add = [&](const std::optional<Bounds>& bounds, CoefficientKind kind,
                         Coefficient ElementEstimate::*which) {
      if (!bounds) return;
      JudgedLimit& fresh =
          judged.emplace_back(JudgedLimit{limit.element, kind, *bounds, LimitVerdict::none, why, doubt != nullptr});
      if (!why.empty()) return;
      fresh.verdict = judge_limit(*bounds, element->*which);
      if (fresh.verdict == LimitVerdict::none) fresh.reason = "the value or its uncertainty is not known";
    };
    add(limit.stiffness, CoefficientKind::stiffness, &ElementEstimate::stiffness);
    add(limit.damping, CoefficientKind::damping, &ElementEstimate::damping);
  }
  return judged;
}

std::vector<JudgedLimit> judge_limits_now(const Rig& rig, const Dwell& current) {
  std::vector<JudgedLimit> judged = judge_limits(rig, current);
  const std::string why = why_not_measured(current.state);
  for (JudgedLimit& limit : judged) {
    if (why.empty() || limit.verdict == LimitVerdict::none) continue;
    limit.verdict = LimitVerdict::none;
    limit.reason = why;
  }
  return judged;
}

}  // namespace dwell
