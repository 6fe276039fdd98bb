// What the intake of a channel found in its readings, and what becomes of its phasor by that: taken into account, or
// withheld.
#include "core/base/wording.hpp"
#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

// Part of a phasor's standard uncertainty by which clipping or repeats may be off without a word.
constexpr double kBiasMatters = 0.3;
// The same, relative to the amplitude, while settling, where no uncertainty is known yet: a tenth of the tolerance.
constexpr double kBiasShows = 0.1;
// Part of the readings that may be left out. What disturbs more also passes the gate now and then: of 30 % zeros and 1
// % noise enough pass to be 30 u, of 10 % none.
constexpr double kMostLeftOut = 0.15;

}  // namespace

bool Pipeline::Impl::unfit(int c) const {
  const ChannelIntake& intake = live[static_cast<std::size_t>(c)].intake;
  return stuck(live[static_cast<std::size_t>(c)]) || intake.clipping_bias() > kBiasShows * rig.tolerance ||
         intake.repeat_bias() > kBiasShows * rig.tolerance || intake.clustered() || intake.left_out() > kMostLeftOut;
}

bool Pipeline::Impl::holding_changed() const {
  return std::any_of(live.begin(), live.end(), [](const Live& channel) { return channel.intake.holding_changed(); });
}

// Instants that are off by so much at either end of the data turn the phase there.
double Pipeline::Impl::refresh_u_omega(double seconds) const {
  double half_s = 0.0;
  for (int c = 0; c < channel_count; ++c)
    if (rig.channels[static_cast<std::size_t>(c)].measures != Quantity::auxiliary)
      half_s = std::max(half_s, live[static_cast<std::size_t>(c)].intake.refresh_half_s());
  return omega * half_s * std::sqrt(2.0 / 3.0) / std::max(seconds, 1e-9);
}

void Pipeline::Impl::judge_readings(int c, ChannelResult& result) const {
  const ChannelIntake& intake = live[static_cast<std::size_t>(c)].intake;
  const HarmonicFit& fit = result.fit;
  if (!fit.usable || rig.channels[static_cast<std::size_t>(c)].measures == Quantity::auxiliary) return;
  const double amplitude = std::abs(fit.X[0]);
  result.refresh_u_s = intake.refresh_half_s() / std::numbers::sqrt3;
  if (!result.withheld.empty()) return;
  const double u = std::hypot(std::sqrt(0.5 * fit.covariance.trace()), result.quantization_u);
  if (intake.clipping_bias() * amplitude > kBiasMatters * u)
    result.withheld = intake.clipped_reason();
  else if (intake.repeat_bias() * amplitude > kBiasMatters * u)
    result.withheld = intake.repeat_reason();
  else if (intake.clustered())
    result.withheld = intake.clustered_reason();
  else if (intake.left_out() > kMostLeftOut)
    result.withheld = intake.left_out_reason();
  else if (state == State::measuring && intake.holding_changed())
    result.withheld = intake.held() ? intake.held_reason() + ", since this dwell began"
                                    : "no longer held between polls, since this dwell began";
}

void Pipeline::Impl::warn_of_readings(Dwell& dwell) const {
  for (int c = 0; c < channel_count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const ChannelIntake& intake = live[i].intake;
    const std::string name = rig.channels[i].name + ": ";
    if (intake.held())
      dwell.warnings.push_back(name + intake.held_reason() + "; each new value counts once, at an instant known to ± " +
                               brief(1e3 * intake.refresh_half_s(), 2) + " ms");
    if (intake.clustered()) dwell.warnings.push_back(name + intake.clustered_reason());
    if (const std::string reason = intake.left_out_reason(); !reason.empty()) dwell.warnings.push_back(name + reason);
    if (intake.repeat_bias() > 0) dwell.warnings.push_back(name + intake.repeat_reason());
    if (intake.clipping_bias() > kBiasShows * rig.tolerance)
      dwell.warnings.push_back(name + intake.clipped_reason() + "; choose a larger range, or a smaller amplitude");
  }
}

}  // namespace dwell
