#include "core/refine.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/harmonic_fit.hpp"

namespace dwell {
namespace {
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr int kSteps = 7;
// A step of less than this part of the uncertainty changes nothing that anyone could see.
constexpr double kNegligible = 1e-2;
}  // namespace

double within_search(const Rig& rig, double omega) noexcept {
  return std::clamp(omega, kTwoPi * rig.excitation.search_low_hz, kTwoPi * rig.excitation.search_high_hz);
}

double refine_and_sum(const Rig& rig, const Blocks& blocks, const BlockRange& range, int reference_channel,
                      std::int64_t fallback_ns, double& omega, Totals& totals) noexcept {
  const int H = rig.excitation.harmonics;
  std::int64_t t_ref_ns = range.from < blocks.count() ? blocks.block(range.from).begin_ns : fallback_ns;
  blocks.sum_channel(reference_channel, range.from, range.to, range.with_open, omega, t_ref_ns, totals);
  const double* instants = totals.channel(reference_channel).instants;
  if (instants[0] > 0) {
    const double mean_s = instants[moments::cosine(2 * H + 1, 1, 0)] / instants[0];
    t_ref_ns += static_cast<std::int64_t>(std::llround(mean_s * 1e9));
  }
  blocks.sum(range.from, range.to, range.with_open, omega, t_ref_ns, totals);
  if (rig.excitation.reference == Reference::fixed) return kTwoPi * rig.excitation.frequency_u_hz;

  double information = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    double score = 0.0;
    information = 0.0;
    for (std::size_t c = 0; c < rig.channels.size(); ++c) {
      if (rig.channels[c].measures == Quantity::auxiliary) continue;
      const HarmonicFit fit = fit_harmonics(totals, static_cast<int>(c), H, 0.0);
      if (!fit.usable) continue;
      score += fit.score;
      information += fit.information;
    }
    if (!(information > 0)) return kTwoPi * rig.excitation.frequency_u_hz;
    const double delta = score / information;
    if (std::abs(delta) * std::sqrt(information) < kNegligible || std::abs(delta) < 1e-14 * omega) break;
    const double next = within_search(rig, omega + delta);
    if (next == omega) break;
    omega = next;
    blocks.sum(range.from, range.to, range.with_open, omega, t_ref_ns, totals);
  }
  return 1 / std::sqrt(information);
}

}  // namespace dwell
