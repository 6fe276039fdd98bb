// Does the drive's frequency contradict what the rig file states of it (reference = "fixed")? Then nothing is reported:
// either the statement is wrong or the clock is, and each coefficient depends on the square of the frequency.
#include "core/base/wording.hpp"
#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr int kShortestHeld = 2 * kQuarters;  // quarters of a hold before its frequency is held against the statement
constexpr int kNewtonSteps = 4;               // of Gauss-Newton, from the windows' own frequency

std::string in_hz(double omega) { return brief(omega / kTwoPi, 7); }

}  // namespace

// By the table alone, in the newest quarters that were never joined: these resolve parts in a million.
std::optional<double> Pipeline::Impl::contradicting_omega() const {
  if (!stated.stated() || state != State::settling || !std::isfinite(drive.omega())) return {};
  const int to = blocks.count();
  const int from =
      std::max(blocks.index_of(steady_serial + static_cast<std::int64_t>(kUnsure * kQuarters)), to - Blocks::kFine);
  if (to - from < kShortestHeld) return {};
  const std::int64_t middle_ns =
      blocks.block(from).begin_ns + (blocks.block(to - 1).end_ns - blocks.block(from).begin_ns) / 2;
  double w = drive.omega(), information = 0.0;
  for (int step = 0; step < kNewtonSteps; ++step) {
    blocks.sum_channel(drive_channel(), from, to, w, middle_ns, window);
    const HarmonicFit fit = fit_harmonics(window, drive_channel(), H, blocks.reference(drive_channel()));
    if (!(fit.information > 0)) return {};
    information = fit.information;
    w += fit.score / fit.information;
  }
  const double by_refresh = refresh_u_omega(to_s(blocks.block(to - 1).end_ns - blocks.block(from).begin_ns));
  if (!stated.contradicted(w, std::hypot(1 / std::sqrt(information), by_refresh))) return {};
  return w;
}

std::string Pipeline::Impl::statement_reason(double w) const {
  return "the drive is at " + in_hz(w) + " Hz, the rig file says fixed at " + in_hz(stated.omega) + " ± " +
         in_hz(2 * stated.u) +
         " Hz (2 u, clock included): correct frequency or frequency_u, or take reference = \"tracked\"";
}

std::string Pipeline::Impl::statement_unfit(const Refined& refined, double seconds) const {
  const double u = std::hypot(refined.u_data, refresh_u_omega(seconds));
  return stated.contradicted(refined.data_omega, u) ? statement_reason(refined.data_omega) : "";
}

}  // namespace dwell
