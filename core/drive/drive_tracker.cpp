#include "core/drive/drive_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/instants.hpp"
#include "core/drive/frequency_search.hpp"
#include "core/fit/blocks.hpp"

namespace dwell {
namespace {

constexpr double kBeats = 0.5;         // part of the drive's frequency: hum farther from the drive averages out
constexpr double kInPhase_rad = 0.02;  // table against dwell, beyond noise: up to here in phase
constexpr double kSlip_rad = 0.1;      // table against dwell, beyond noise: from here on another frequency
constexpr double kStopped = 0.25;      // part of the reference's amplitude: an uncertain window below it shows no drive

}  // namespace

DriveTracker::DriveTracker(const Rig& rig, const DriveReference& reference)
    : rig_(rig), reference_(reference), monitor_(rig.tolerance), watch_(rig.tolerance) {}

// Standard deviation of either component of the window's Y, m (rad).
double DriveTracker::u_of(const Window& window, const During& during) const noexcept {
  const HarmonicFit& fit = window.fit;
  const double per_reading = std::abs(window.Y) / std::max(std::abs(fit.X[0]), 1e-300);
  // With few degrees of freedom the noise is itself uncertain.
  const double few = 1 + 4 / std::max(1.0, fit.samples - (2 * rig_.excitation.harmonics + 1));
  // While measuring, the noise of the whole dwell is the lower bound.
  const double more_noise = during.counting ? std::max(1.0, hold_.sigma2 / fit.sigma2) : 1.0;
  return few * std::sqrt(0.5 * more_noise * fit.covariance.trace()) * per_reading;
}

DriveTracker::Sight DriveTracker::see(const Window& window, double acquired_omega, const During& during) noexcept {
  const double amplitude = std::abs(window.Y), u = u_of(window, during);
  // Before the phase tells the frequency, the window's own is used.
  const double seen_omega = std::isfinite(omega()) ? omega() : acquired_omega;
  seen_.take(amplitude, seen_omega / kTwoPi, during.dwell);
  // While measuring the amplitude must be small as well: one bad reading makes a window uncertain too.
  const bool uncertain =
      amplitude < sigmas::kNoise * u && (!during.measuring || amplitude < kStopped * monitor_.amplitude());
  const bool low = amplitude < rig_.excitation.minimum || uncertain;
  // A drive at twice the window's frequency has the fundamental zero here, and yet the table moves.
  const bool elsewhere = low && window.elsewhere >= rig_.excitation.minimum && window.elsewhere >= sigmas::kNoise * u;
  if (low && !elsewhere) return ++low_windows_ >= 2 ? Sight::rests : Sight::low;
  low_windows_ = 0;
  if (elsewhere) return Sight::elsewhere;
  return amplitude < sigmas::kSure * u ? Sight::faint : Sight::moves;
}

bool DriveTracker::changed(const Window& window, double since_s, double bend_rad, double omega,
                           const During& during) noexcept {
  const bool other = monitor_.update(since_s, window.Y * std::polar(1.0, bend_rad), u_of(window, during), omega);
  const bool stepped = watch_.close();
  return stepped || (other && !watch_.watches()) || slipped(window, during);
}

// Whether this window and the one before are out of phase with the data that count.
bool DriveTracker::slipped(const Window& window, const During& during) noexcept {
  if (!during.counting) return false;
  const HarmonicFit& fit = window.fit;
  const double since_s = to_s(window.centre_ns - hold_.t_ref_ns);  // the window's phase is already free of known drift
  const double off = std::remainder(std::arg(fit.X[0]) - hold_.phase_rad - hold_.omega * since_s, kTwoPi);
  // A window of few readings may underestimate its noise; the noise of the whole dwell is the lower bound.
  const double more_noise = std::max(1.0, hold_.sigma2 / fit.sigma2);
  const double u = std::hypot(std::sqrt(0.5 * more_noise * fit.covariance.trace()) / std::abs(fit.X[0]),
                              hold_.u_omega * since_s, hold_.omega * watch_.extra_u_s());
  slips_ = std::abs(off) > kSlip_rad + 4 * u ? slips_ + 1 : 0;
  since_in_phase_ = std::abs(off) > kInPhase_rad + 4 * u ? since_in_phase_ + 1 : 0;
  return slips_ >= 2;
}

void DriveTracker::begin_hold() noexcept {
  slips_ = since_in_phase_ = 0;
  monitor_.restart();
  watch_.restart();
}

void DriveTracker::stop_counting() noexcept {
  slips_ = since_in_phase_ = 0;
  watch_.restart();
}

void DriveTracker::refer(const Known& known, const SamplingRegularity& sampling) noexcept {
  const HarmonicFit& fit = known.fit;
  const std::complex<double> X = fit.X[0];
  const double w = known.omega;
  hold_ = {known.t_ref_ns, std::arg(X), w, known.u_omega, fit.sigma2};
  monitor_.refer(known.amplitude, w);
  if (!fit.usable) return;
  const double u = std::sqrt(0.5 * fit.covariance.trace()) / std::abs(X);
  // The frequency by the table alone: the other channels may still hold a little of their transient.
  const FrequencyPrior& stated = reference_.stated();
  const bool told = reference_.inexact() && fit.information > 0;
  const double information = fit.information + stated.information();
  const double table_omega = told ? w + (fit.score + stated.score(w)) / information : w;
  const double u_table_omega = told ? 1 / std::sqrt(information) : known.u_omega;
  watch_.refer({known.t_ref_ns, fit.mean, fit.X, rig_.excitation.harmonics, table_omega, known.drift,
                std::sqrt(fit.sigma2), u, u, u_table_omega, known.rounding_u / std::abs(X)});
  watch_.expect_beats(std::any_of(std::begin(kMainsFundamentals_hz), std::end(kMainsFundamentals_hz), [&](double line) {
    return sampling.distance_hz(line, w / kTwoPi) < kBeats * w / kTwoPi;
  }));
}

bool DriveTracker::out_of_search() const noexcept {
  const double f = omega() / kTwoPi;
  return !reference_.stated().stated() && std::isfinite(f) &&
         (f < rig_.excitation.search_low_hz || f > rig_.excitation.search_high_hz);
}

int DriveTracker::doubtful_quarters() const noexcept {
  return watch_.watches() ? watch_.since_good() : std::min(monitor_.windows_since_good(), 2 * kQuarters);
}

// A change may have begun a quarter before the first doubtful window, and a ramp is doubted only some time after it has
// begun. Doubts by amplitude reach back two periods at most; doubts by phase reach back to the beginning of the slip.
int DriveTracker::quarters_of_change() const noexcept { return std::max(doubtful_quarters() + 2, since_in_phase_ + 1); }

}  // namespace dwell
