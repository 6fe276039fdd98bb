#include "core/drive/refine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.hpp"
#include "core/fit/frequency_prior.hpp"
#include "core/fit/harmonic_fit.hpp"

namespace dwell {
namespace {
constexpr int kRefinements = 7;     // at most; with more the last bits of some dwells change
constexpr double kFurthest = 5e-3;  // most turning at the ends of the data, rad

// Whether turning the sums by delta (rad/s) costs at most kFurthest³/6, 2e-8, of Σs². a: half the length of the data.
// Over a hundred periods and more turning costs (δa)³/6. Over few it costs more, since u² is taken at its mean: in
// exact sums of 1 … 100 periods about (δa)²/(5 ωa), and (δa)²/(3.5 ωa) at most (docs/method.md, Frequency).
bool can_turn(double delta, double mean_square_u, double omega) noexcept {
  const double half_s = std::sqrt(3 * mean_square_u), most = kFurthest * kFurthest * kFurthest / 6;
  return std::abs(delta) * half_s <= std::min(kFurthest, std::sqrt(3.5 * most * omega * half_s));
}

}  // namespace

Refined refine(const PulseLine& pulses, const Totals& sums, int reference_channel, Totals& out) noexcept {
  const std::int64_t t_ref_ns = pulses.nearest_ns(sums.centroid_ns(reference_channel));
  sums.turned(pulses.omega, t_ref_ns, out);
  const double mean_square = moments::mean_square_u(out.channel(reference_channel).instants, 2 * out.harmonics() + 1);
  return {pulses.omega, pulses.u, can_turn(pulses.omega - sums.omega(), mean_square, pulses.omega)};
}

double within_search(const Rig& rig, double omega) noexcept {
  return stated_frequency(rig).within(
      std::clamp(omega, kTwoPi * rig.excitation.search_low_hz, kTwoPi * rig.excitation.search_high_hz));
}

Refined refine(const Rig& rig, const Totals& sums, int reference_channel, Totals& out) noexcept {
  const int H = rig.excitation.harmonics;
  const std::int64_t t_ref_ns = sums.centroid_ns(reference_channel);
  const FrequencyPrior stated = stated_frequency(rig);
  Refined result{.omega = within_search(rig, sums.omega())};
  sums.turned(result.omega, t_ref_ns, out);
  for (int step = 0; step < kRefinements; ++step) {
    HarmonicFits fits(out, H);
    double score = 0.0, information = 0.0, longest = 0.0;
    for (std::size_t c = 0; c < rig.channels.size(); ++c) {
      if (rig.channels[c].measures == Quantity::auxiliary) continue;
      const HarmonicFit fit = fits.fit(static_cast<int>(c), 0.0);
      if (!fit.usable) continue;
      score += fit.score;
      information += fit.information;
      longest = std::max(longest, moments::mean_square_u(out.channel(static_cast<int>(c)).instants, 2 * H + 1));
    }
    if (information > 0) {
      result.data_omega = result.omega + score / information;
      result.u_data = 1 / std::sqrt(information);
    }
    if (stated.exact()) break;
    score += stated.score(result.omega);
    information += stated.information();
    if (!(information > 0)) {
      result.u = std::numeric_limits<double>::quiet_NaN();
      break;
    }
    result.u = 1 / std::sqrt(information);
    const double delta = score / information;
    if (std::abs(delta) < kNegligibleStep * result.u || std::abs(delta) < 1e-14 * result.omega) break;
    const double next = within_search(rig, result.omega + delta);
    if (next == result.omega) break;
    result.omega = next;
    if (!can_turn(next - sums.omega(), longest, next)) {
      result.sums_valid = false;
      break;
    }
    sums.turned(next, t_ref_ns, out);
  }
  return result;
}

}  // namespace dwell
