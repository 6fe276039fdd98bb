// A knock while the rig settles: its natural oscillations begin anew, the drive and the poles stay as they are
// (docs/method.md, Settling).
#include <utility>

#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr double kLookAgain =
    0.25;  // of the time since a knock, and at least a period: before its data are tried again
constexpr double kFewPeriods = 2.0;   // of undisturbed motion, from which poles that are known may be believed
constexpr double kBesideKnown = 0.1;  // relative: a chain's pole that near to one that the data show is that one
constexpr int kSteps = 2;             // of refinement, at each begin that is tried

}  // namespace

// The free motion since the last knock is fitted by itself, by poles that are known: of ever later begins the earliest
// from which on they explain the data. false: there is none yet.
bool Pipeline::Impl::fit_since_knock(double w, std::int64_t first_ns) {
  const std::int64_t was_from_ns = hold_fit.from_ns();
  const auto least_ns = to_ns(kFewPeriods * period_s());
  known_poles.assign(modal_poles.begin(), modal_poles.end());
  for (const Complex& pole : decay.poles())
    if (std::none_of(known_poles.begin(), known_poles.end(),
                     [&](Complex other) { return std::abs(pole - other) < kBesideKnown * std::abs(pole); }))
      known_poles.push_back(pole);
  for (std::int64_t length_ns = now_ns - first_ns; length_ns >= least_ns && hold_fit.may_fit(); length_ns /= 2) {
    hold_fit.begin_at(now_ns - length_ns);
    const std::int64_t free_before_ns = knock_watch.free_since_ns();
    knock_watch.set_free_since(hold_fit.from_ns());
    keep_alive(known_poles, best_poles);
    const double w_then = w + hold_fit.rate() * to_s(hold_fit.from_ns() - was_from_ns);
    refine_poles(fit_modes(w_then, best_poles), kSteps);
    if (hold_fit.determined() && explained()) return true;
    knock_watch.set_free_since(free_before_ns);
  }
  hold_fit.begin_at(was_from_ns);
  return false;
}

// Asks for a refit once enough has been seen since.
void Pipeline::Impl::heed_knock(std::int64_t end_ns) {
  knock_watch.alarm(end_ns);
  schedule.plan(end_ns + to_ns((kFewPeriods + 0.5) * period_s()));
}

void Pipeline::Impl::refit_after_knock() {
  const auto again_ns =
      static_cast<std::int64_t>(kLookAgain * static_cast<double>(now_ns - knock_watch.free_since_ns()));
  schedule.plan_no_later_than(now_ns + std::max(to_ns(period_s()), again_ns));
}

}  // namespace dwell
