#include "core/transient/transient_left.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/chance.hpp"

namespace dwell {
namespace {

// A verdict asks for this part of what is allowed, which is itself an estimate. No derivation; set on the study. White
// noise: at 0.8, 0.85, 0.9 the median lateness is 0.50, 0.38, 0.27, and at the latter two none of 600 verdicts comes
// too early. Rounding: no uncertainty holds what it does to the fit. Of channels rounded more coarsely than their noise
// 11 of 2000 come too early at 0.85 and at 0.82, 8 at 0.80.
constexpr double kSafety = 0.85, kSafetyRounded = 0.80;
constexpr double kMostTakenOut = 8.0;  // times what is allowed, where data begin to count
constexpr double kAboveZero = 1e-300;  // keeps the divisor above 0 for a channel at rest

}  // namespace

double TransientLeft::allowed(int channel, const HoldNow& now) const noexcept {
  const ModalFit& fit = fit_.fit();
  const double span_s = std::max(1e-9, to_s(now.now_ns - fit.t0_ns()));
  const double in_ten = std::max(1.0, fit.samples(channel) / span_s * 10 * now.period_s());
  const double floor = noise_.smallest_variance(channel, fit);
  return std::max({tolerance_ * std::abs(fit.phasor(channel, 1)), 3 * std::sqrt(floor * 2 / in_ten), kAboveZero});
}

bool TransientLeft::hidden_by_rounding(int channel, const HoldNow& now) const noexcept {
  return fit_.fit().usable(channel) && now.channel(channel).hides(fit_.fit().variance(channel));
}

bool TransientLeft::rounded(const HoldNow& now) const noexcept {
  for (int c = 0; c < fit_.channels(); ++c)
    if (hidden_by_rounding(c, now)) return true;
  return false;
}

TransientLeft::Worst TransientLeft::at(std::int64_t t_ns, const HoldNow& now) const noexcept {
  const ModalFit& fit = fit_.fit();
  Worst worst;
  for (int c = 0; c < fit_.channels(); ++c) {
    if (!now.channel(c).watched) continue;
    if (!fit.usable(c)) return {INFINITY, worst.channel};
    if (now.channel(c).imposed) continue;
    const double may_be = allowed(c, now);
    const ModalFit::Left left = fit.left(c, t_ns);
    double ratio =
        (left.envelope + sigmas::kNoise * left.u) / ((hidden_by_rounding(c, now) ? kSafetyRounded : kSafety) * may_be);
    // Residuals beyond the noise may be transient.
    if (const double power = noise_.unexplained(c, fit, now); power > 0)
      ratio = std::max(ratio, std::sqrt(2 * power) / may_be);
    if (ratio > worst.left) worst = {ratio, c};
  }
  return worst;
}

void TransientLeft::tell(std::int64_t t_ns, const HoldNow& now, SettlingDetector::Verdict& verdict) const noexcept {
  const Worst worst = at(t_ns, now);
  verdict.worst_left = worst.left;
  if (worst.channel >= 0) verdict.worst_channel = worst.channel;
}

// The data count from the earliest instant at which a verdict would have been right. The last two periods before the
// verdict count as well, as far back as what may be left there stays within kMostTakenOut times what is allowed.
std::optional<std::int64_t> TransientLeft::counts_from(std::int64_t end_ns, const HoldNow& now) const noexcept {
  const auto quarter_ns = to_ns(now.period_s() / kQuarters);
  const std::int64_t all = (end_ns - fit_.fit().t0_ns()) / quarter_ns;
  const auto back_to = [&](double most) {
    std::int64_t back = 0, too_far = all + 1;
    while (too_far - back > 1) {
      const std::int64_t middle = back + (too_far - back) / 2;
      (at(end_ns - middle * quarter_ns, now).left > most ? too_far : back) = middle;
    }
    return back;
  };
  const std::int64_t back = std::max(back_to(1.0), std::min<std::int64_t>(2 * kQuarters, back_to(kMostTakenOut)));
  if (back < kFewestQuarters) return {};
  return end_ns - back * quarter_ns;
}

std::optional<TransientLeft::Premature> TransientLeft::premature(std::int64_t verdict_ns,
                                                                 const HoldNow& now) const noexcept {
  const ModalFit& fit = fit_.fit();
  std::optional<Premature> premature;
  double most = 1.0;
  for (int c = 0; c < fit_.channels(); ++c) {
    if (!now.channel(c).watched || !fit.usable(c) || now.channel(c).imposed) continue;
    const ModalFit::Left left = fit.left(c, verdict_ns);
    const double may_be = allowed(c, now);
    if ((left.swing - sigmas::kNoise * left.u) / may_be <= most) continue;
    most = (left.swing - sigmas::kNoise * left.u) / may_be;
    premature = {verdict_ns, c, left.swing / may_be};
  }
  return premature;
}

}  // namespace dwell
