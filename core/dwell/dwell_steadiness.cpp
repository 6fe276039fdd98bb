// Detects changes within a dwell: of one channel against the table, of the table itself, of the drive's frequency.
#include <utility>

#include "core/base/chance.hpp"
#include "core/base/wording.hpp"
#include "core/dwell/pipeline_impl.hpp"
#include "core/fit/scatter.hpp"

namespace dwell {
namespace {

// Tolerances from which a slope is reported if the data have stretches, which show everything worth a word but a slow
// drift.
constexpr double kToldOfLong = 0.5;
// The largest change, in tolerances, that a slope alone describes in a dwell too short for stretches. Of 400 dwells of
// 0.4 s whose amplitude hunts by 1 %, those off by five standard uncertainties had changed by 0.4 or more. At half this
// limit sound dwells would be doubted.
constexpr double kDoubted = 0.25;

// Rms of the stretches' deviations, relative to the phasor: along it and across.
struct Wander {
  double amplitude = 0.0, phase_rad = 0.0;
};

Wander wander_of(const ChannelResult& result) {
  Wander sum;
  double count = 0.0;
  for (const PhasorStretch& stretch : result.stretches) {
    if (!stretch.usable) continue;
    const Complex relative = stretch.off / result.fit.X[0];
    sum.amplitude += relative.real() * relative.real();
    sum.phase_rad += relative.imag() * relative.imag();
    count += 1.0;
  }
  count = std::max(1.0, count);
  return {std::sqrt(sum.amplitude / count), std::sqrt(sum.phase_rad / count)};
}

// Relative change of the drive since the modal fit: Y / Y_fit - 1. Y is the table's phasor over the data that count;
// Y_fit is the table's phasor of the modal fit, made while the rig settled.
Complex since_fitted(const HarmonicFit& table, const ModalFit& modal, int channel, std::int64_t t_ref_ns) {
  return table.X[0] / (modal.phasor(channel, 1) * std::polar(1.0, modal.angle(t_ref_ns))) - 1.0;
}

}  // namespace

// E|ΔX_1|² by the drift of the instants of a slowly refreshed register: known to ± h, they turn the phasor by ωh/√3.
double Pipeline::Impl::turned_by_refresh(int c, const HarmonicFit& fit) const {
  return std::norm(omega() * live[c].intake().widest_refresh_half_s() * fit.X[0]) / 3;
}

void Pipeline::Impl::look_within(int from, int to, double seconds, HarmonicFits& fits,
                                 std::vector<ChannelResult>& results) const {
  std::vector<const HarmonicFit*> of_channels;
  for (const ChannelResult& result : results) of_channels.push_back(&result.fit);
  auto stretches = data.stretches(from, to, of_channels);
  const Complex turn = std::polar(1.0, data.bend(data.totals().t_ref_ns()));
  for (int c = 0; c < live.count(); ++c) {
    ChannelResult& result = results[static_cast<std::size_t>(c)];
    result.stretches = std::move(stretches[static_cast<std::size_t>(c)]);
    result.slope = fits.slope(c, result.fit, blocks().reference(c));
    // Such errors of the instants are not those of the drive: they count as noise of each stretch, and at either end.
    if (const double turned = turned_by_refresh(c, result.fit); turned > 0) {
      for (PhasorStretch& stretch : result.stretches) stretch.add_variance(turned);
      if (result.slope.variance > 0) result.slope.variance += 2 * turned / (seconds * seconds);
    }
    result.scatter = scatter_of(result.stretches);
    for (PhasorStretch& stretch : result.stretches) stretch.off *= turn;
    result.slope.value *= turn;
  }
}

// E|ΔX_1|² of the table's phasor and, where instants are uncertain, of the one while the rig settled.
double Pipeline::Impl::variance_since_fitted(const HarmonicFit& table) const {
  return table.covariance.trace() + 2 * turned_by_refresh(drive_channel(), table);
}

// Did the drive change since the rig settled? Then the modal fit may have taken the masses' answer to that change for a
// natural oscillation and removed it from the data. In channel c this error is at most as large as the change itself,
// and at most as large as the oscillation that was removed from c.
void Pipeline::Impl::look_at_settling(std::vector<ChannelResult>& results) const {
  const HarmonicFit& table = results[static_cast<std::size_t>(drive_channel())].fit;
  if (!modes.removal().active() || !table.usable || !modes.fit().usable(drive_channel())) return;
  const Complex change = since_fitted(table, modes.fit(), drive_channel(), data.totals().t_ref_ns());
  if (!(std::norm(change * table.X[0]) > nats::kOneIn100 * variance_since_fitted(table))) return;
  for (int c = 0; c < live.count(); ++c) {
    ChannelResult& result = results[static_cast<std::size_t>(c)];
    if (!result.fit.usable || shows_drive(rig.channels[static_cast<std::size_t>(c)])) continue;
    const double taken_out = 2 / result.fit.samples * modes.removal().taken_out(c).norm();
    const Complex answer = change * result.fit.X[0];
    result.taken_for_transient = answer * std::min(1.0, taken_out / std::abs(answer));
  }
}

// If one channel's ratio to the table varies, the channel or its mount has changed. If all vary, the table's
// transducer, the rig or the drive's frequency has: masses answer otherwise at another frequency.
void Pipeline::Impl::warn_of_change(const std::vector<ChannelResult>& results, double seconds, Dwell& dwell) const {
  const auto table = static_cast<std::size_t>(drive_channel());
  std::vector<std::vector<PhasorStretch>> stretches;
  for (const ChannelResult& result : results) stretches.push_back(result.stretches);
  if (!results[table].fit.usable) return;
  std::vector<std::string> unsteady;  // names
  std::vector<Warning> warnings;
  double largest = 0.0;
  std::size_t judged = 0;
  for (std::size_t c = 0; c < results.size(); ++c) {
    if (c == table || !results[c].withheld.empty() || !results[c].fit.usable) continue;
    ++judged;
    Eigen::VectorXcd against = Eigen::VectorXcd::Zero(live.count());
    against(static_cast<Eigen::Index>(c)) = 1.0 / results[c].fit.X[0];
    against(drive_channel()) = -1.0 / results[table].fit.X[0];
    const Scatter scatter = scatter_of_sum(against, stretches);
    if (!(scatter.ratio > Scatter::kUnsteady) || !scatter.shows()) continue;
    const Wander wander = wander_of(results[c]);
    if (!(std::max(wander.amplitude, wander.phase_rad) > kToleranceShare * rig.tolerance)) continue;
    const double by = std::sqrt(scatter.ratio);
    const std::string& name = rig.channels[c].name;
    unsteady.push_back(name);
    warnings.push_back({WarningKind::unsteady,
                        name + " is not steady: its ratio to the table varies by " + brief(by, 2) +
                            " times its noise; check the transducer and its mount",
                        {},
                        {name}});
    largest = std::max(largest, by);
  }
  if (unsteady.size() > 1 && unsteady.size() == judged) {
    const std::string& name = rig.channels[table].name;
    warnings = {{WarningKind::unsteady,
                 "the ratio of every channel to " + name + " varies, by up to " + brief(largest, 2) +
                     " times its noise: the drive's frequency drifts, or " + name +
                     ", its mount or the rig itself has changed",
                 {},
                 unsteady}};
  }
  for (Warning& warning : warnings) dwell.warnings.push_back(std::move(warning));
  const Wander drive_wanders = wander_of(results[table]);
  if (results[table].scatter.shows() && results[table].scatter.ratio > Scatter::kUnsteady &&
      std::max(drive_wanders.amplitude, drive_wanders.phase_rad) > kToleranceShare * rig.tolerance) {
    dwell.warnings.push_back(
        {WarningKind::unsteady, "the drive is not steady: within the dwell its amplitude varies by " +
                                    percent(drive_wanders.amplitude) + " and its phase by " +
                                    brief(drive_wanders.phase_rad, 2) + " rad (rms); c and r are those of the mean"});
    return;
  }
  const Complex rate = results[table].slope.value / results[table].fit.X[0];
  const double changed = std::abs(rate) * seconds;
  // In data too short for stretches only the slope shows a change.
  // Slopes that show in one healthy dwell of a hundred only widen the uncertainty.
  const double told = results[table].scatter.dof > 0 ? nats::kOneIn10000 : nats::kOneIn100;
  const double least = results[table].scatter.dof > 0 ? kToldOfLong : kToleranceShare;
  const bool sure = std::norm(results[table].slope.value) > told * results[table].slope.variance;
  if (!results[table].slope.shows() || !sure || !(changed > least * rig.tolerance)) {
    double absorbed = 0.0;  // the largest, as a part of the phasor
    for (const ChannelResult& result : results)
      if (result.fit.usable) absorbed = std::max(absorbed, std::abs(result.taken_for_transient / result.fit.X[0]));
    // Long after the transient was fitted an error of its frequency turns the phasor: the drive has not changed.
    if (results[table].scatter.dof > 0 || !(absorbed > kToleranceShare * rig.tolerance)) return;
    const Complex change = since_fitted(results[table].fit, modes.fit(), drive_channel(), data.totals().t_ref_ns());
    if (std::norm(change * results[table].fit.X[0]) > told * variance_since_fitted(results[table].fit))
      dwell.warnings.push_back(
          {WarningKind::unsteady, "the drive is not steady: while the rig settled its amplitude changed by " +
                                      percent(change.real()) + " and its phase by " + brief(change.imag(), 2) +
                                      " rad; the uncertainties allow for it (\"drive's change while settling\")"});
    return;
  }
  const std::string seen = "the drive is not steady: its amplitude changes by " + percent(rate.real()) +
                           " and its phase by " + brief(rate.imag(), 2) + " rad in a second";
  if (rig.mass_count() > 0 && results[table].scatter.dof == 0 && changed > kDoubted * rig.tolerance)
    dwell.doubts.push_back({{}, seen + ", in data of " + brief(seconds, 2) + " s; wait until it is steady"});
  else
    dwell.warnings.push_back(
        {WarningKind::unsteady, seen + "; the uncertainties allow for it (\"change within the dwell\")"});
}

// Factor by which wandering phases widen the standard uncertainty of the frequency, over that by white residuals.
double Pipeline::Impl::frequency_widens(const ChannelResult& table) const {
  if (!table.fit.usable) return 1.0;
  double sum = 0.0, count = 0.0;
  for (const PhasorStretch& stretch : table.stretches) {
    if (!stretch.usable || !(stretch.variance > 0)) continue;
    const double off = (stretch.off / table.fit.X[0]).imag();
    sum += off * off * std::norm(table.fit.X[0]) / (0.5 * stretch.variance);
    count += 1.0;
  }
  // Two parameters are fitted: phase and frequency.
  if (count < 4) return 1.0;
  return std::sqrt(Scatter{sum / (count - 2), count - 2}.widens());
}

}  // namespace dwell
