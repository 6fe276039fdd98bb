#include "core/transient/refit_schedule.hpp"

#include <algorithm>

#include "core/base/instants.hpp"
#include "core/transient/hold_now.hpp"

namespace dwell {
namespace {

constexpr double kSudden = 1.2;  // a claim is sudden where the one before was above this, times what is allowed

}  // namespace

bool RefitSchedule::due(std::int64_t now_ns) const noexcept {
  return next_ == Next::at_once || (next_ == Next::at_instant && now_ns >= at_ns_);
}

void RefitSchedule::plan(std::int64_t at_ns) noexcept {
  next_ = Next::at_instant;
  at_ns_ = at_ns;
}

void RefitSchedule::plan_growth(double growth, std::int64_t free_since_ns, std::int64_t now_ns) noexcept {
  plan(free_since_ns + static_cast<std::int64_t>(growth * static_cast<double>(now_ns - free_since_ns)));
}

void RefitSchedule::plan_no_later_than(std::int64_t at_ns) noexcept {
  if (next_ == Next::never)
    plan(at_ns);
  else if (next_ == Next::at_instant)
    at_ns_ = std::min(at_ns_, at_ns);
}

bool RefitSchedule::believes(const Claim& claim, double period_s, std::int64_t free_since_ns,
                             std::int64_t now_ns) noexcept {
  if (claim.left > 1) {
    confirm_ns_.reset();
    return false;
  }
  if (!confirm_ns_) {
    if (!claim.rounded || !(claim.left_before > kSudden)) return true;
    confirm_ns_ = now_ns + std::max(to_ns(kPeriodsToTell * period_s),
                                    static_cast<std::int64_t>(kAgain * static_cast<double>(now_ns - free_since_ns)));
    plan(*confirm_ns_);
  }
  return now_ns >= *confirm_ns_;
}

}  // namespace dwell
