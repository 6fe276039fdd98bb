// A knock while the rig settles: its natural oscillations begin anew, the drive and the poles stay as they are
// (docs/method.md, Settling).
#include <utility>

#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

// Standard deviations of the newest quarter's residual power beyond the noise: by noise alone once in 10⁷ quarters of a
// channel, some 30 hours of one at 25 Hz. A false alarm costs a refit, no data. Half of it asks for many; twice sees
// knocks of a few standard deviations of a reading one refit later.
constexpr double kSureOfKnock = 6.0;
constexpr double kLookAgain =
    0.25;  // of the time since a knock, and at least a period: before its data are tried again
constexpr double kFewPeriods = 2.0;   // of undisturbed motion, from which poles that are known may be believed
constexpr double kBesideKnown = 0.1;  // relative: a chain's pole that near to one that the data show is that one
constexpr int kSteps = 2;             // of refinement, at each begin that is tried

}  // namespace

// Whether the newest quarter of a period holds more than noise beside a fit that explained all before.
bool Pipeline::Impl::knocked_now(std::int64_t from_ns) {
  std::fill(of_quarter.begin(), of_quarter.end(), Newest{});
  for (auto i = history.first_at(from_ns); i < modal_next; ++i) {
    const SampleHistory::Sample& s = history[i];
    if (!modal.usable(s.channel)) continue;
    const double r = modal.residual(s.channel, s.t_ns, s.value);
    Newest& of = of_quarter[static_cast<std::size_t>(s.channel)];
    of.squares += r * r;
    of.count += 1.0;
  }
  for (int c = 0; c < channel_count; ++c) {
    if (shows_drive(rig.channels[static_cast<std::size_t>(c)])) continue;
    const Newest& of = of_quarter[static_cast<std::size_t>(c)];
    const Noise& noise = noises[static_cast<std::size_t>(c)];
    if (!(of.count > 0) || !(noise.freedom >= 4)) continue;
    const double variance = std::max(noise.variance, modal.variance(c));
    // Of χ² of few readings the tail is longer than the normal one.
    const double beyond =
        kSureOfKnock * std::sqrt(2 / of.count + 2 / noise.freedom) + kSureOfKnock * kSureOfKnock / of.count;
    if (of.squares > variance * of.count * (1 + beyond)) return true;
  }
  return false;
}

// The free motion since the last knock is fitted by itself, by poles that are known: of ever later begins the earliest
// from which on they explain the data. false: there is none yet.
bool Pipeline::Impl::fit_since_knock(double w, std::int64_t first_ns) {
  const std::int64_t was_from_ns = modal_from_ns;
  const auto least_ns = to_ns(kFewPeriods * period_s());
  known_poles.assign(modal_poles.begin(), modal_poles.end());
  for (const Complex& pole : decay.poles())
    if (std::none_of(known_poles.begin(), known_poles.end(),
                     [&](Complex other) { return std::abs(pole - other) < kBesideKnown * std::abs(pole); }))
      known_poles.push_back(pole);
  for (std::int64_t length_ns = now_ns - first_ns; length_ns >= least_ns && fits_left > 0; length_ns /= 2) {
    modal_from_ns = now_ns - length_ns;
    const std::int64_t free_before_ns = std::exchange(free_ns, modal_from_ns);
    keep_alive(known_poles, best_poles);
    const double w_then = w + modal_rate * to_s(modal_from_ns - was_from_ns);
    refine_poles(fit_modes(w_then, best_poles), kSteps);
    if (determined() && explained()) return true;
    free_ns = free_before_ns;
  }
  modal_from_ns = was_from_ns;
  return false;
}

// Asks for a refit once enough has been seen since.
void Pipeline::Impl::heed_knock(std::int64_t end_ns) {
  knock_ns = end_ns;
  knocks = true;
  modal_refit_at_ns = end_ns + to_ns((kFewPeriods + 0.5) * period_s());
}

void Pipeline::Impl::refit_after_knock() {
  const auto again_ns = static_cast<std::int64_t>(kLookAgain * static_cast<double>(now_ns - free_ns));
  modal_refit_at_ns = std::min(modal_refit_at_ns, now_ns + std::max(to_ns(period_s()), again_ns));
}

}  // namespace dwell
