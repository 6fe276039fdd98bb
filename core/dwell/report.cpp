#include "core/dwell/report.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/chain/contradiction.hpp"
#include "core/chain/mode_check.hpp"
#include "core/dwell/twin_channels.hpp"
#include "core/rig/transducer.hpp"
#include "core/rig/unstated.hpp"

namespace dwell {
namespace {

std::string reason_of(const ChannelResult& channel) {
  if (!channel.withheld.empty()) return channel.withheld;
  return channel.fit.usable ? "" : "too few samples in the data that count";
}

// The variance that the phases of two channels share, rad²: of delays common to both.
double shared_phase_variance(const Rig& rig, const std::vector<ChannelResult>& channels, double omega, std::size_t a,
                             std::size_t b) {
  double variance_s2 = 0.0;
  if (const int device = rig.channels[a].device; device >= 0 && device == rig.channels[b].device)
    variance_s2 += std::pow(rig.devices[static_cast<std::size_t>(device)].delay_u_s, 2);
  if (channels[a].transaction >= 0 && channels[a].transaction == channels[b].transaction)
    variance_s2 += channels[a].turnaround_u_s * channels[b].turnaround_u_s;
  if (channels[a].uneven.with >= 0 && channels[a].uneven.with == channels[b].uneven.with)
    variance_s2 += channels[a].uneven.shared_s * channels[b].uneven.shared_s;
  return omega * omega * variance_s2;
}

void report_relative_phases(const Rig& rig, const std::vector<ChannelResult>& channels, double omega, Dwell& dwell) {
  const auto valid = [](const ChannelPhasor& p) { return p.valid && std::abs(p.Y) > 0.0; };
  const auto first = std::find_if(dwell.phasors.begin(), dwell.phasors.end(), valid);
  if (first == dwell.phasors.end()) return;
  const auto reference = static_cast<std::size_t>(first - dwell.phasors.begin());
  for (std::size_t c = reference; c < dwell.phasors.size(); ++c) {
    ChannelPhasor& p = dwell.phasors[c];
    const double shared = shared_phase_variance(rig, channels, omega, c, reference);
    p.u_relative_phase_rad = c == reference ? 0.0
                                            : std::sqrt(std::max(0.0, std::pow(p.u_phase_rad, 2) - shared) +
                                                        std::max(0.0, std::pow(first->u_phase_rad, 2) - shared));
  }
}

}  // namespace

void report_phasors(const Rig& rig, const std::vector<ChannelResult>& channels, double omega, double u_omega,
                    Dwell& dwell) {
  const int H = rig.excitation.harmonics;
  dwell.unstated = unstated_uncertainties(rig);
  dwell.frequency_hz = {omega / kTwoPi, std::hypot(u_omega, omega * rig.excitation.clock_u) / kTwoPi};
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const Channel& channel = rig.channels[c];
    const HarmonicFit& fit = channels[c].fit;
    ChannelPhasor out;
    out.reason = reason_of(channels[c]);
    out.valid = out.reason.empty();
    out.samples = fit.samples;
    if (fit.usable) {
      const bool on_device = channel.device >= 0;
      const Device device = on_device ? rig.devices[static_cast<std::size_t>(channel.device)] : Device{};
      const std::complex<double> X = fit.X[0], H_1 = response(channel, device.delay_s, omega / kTwoPi);
      const double amplitude = std::abs(X);
      out.Y = X / H_1;
      out.mean = fit.mean;
      out.sigma = std::sqrt(fit.sigma2);
      const Eigen::Vector2d along(X.real() / amplitude, X.imag() / amplitude), across(-along(1), along(0));
      const Eigen::Matrix2d covariance = channels[c].scatter.widens() * fit.covariance;
      const double u_along = std::sqrt(along.dot(covariance * along)) / amplitude;
      const double u_across = std::sqrt(across.dot(covariance * across)) / amplitude;
      const double transient_u = std::hypot(std::sqrt(0.5 * channels[c].transient.trace()), channels[c].folded_u);
      out.u_amplitude =
          std::abs(out.Y) *
          std::hypot(u_along, std::hypot(std::hypot(channel.scale_u, channels[c].uneven.part), transient_u / amplitude,
                                         channels[c].quantization_u / amplitude));
      out.u_phase_rad = std::hypot(
          u_across, std::hypot(transient_u, channels[c].quantization_u) / amplitude,
          omega * std::hypot(std::hypot(channel.delay_u_s, channels[c].refresh_u_s, channels[c].uneven.own_s),
                             device.delay_u_s, std::hypot(channels[c].turnaround_u_s, channels[c].uneven.shared_s)));
      for (int h = 2; h <= H; ++h)
        out.harmonics.push_back(
            std::abs(fit.X[static_cast<std::size_t>(h - 1)] / response(channel, device.delay_s, h * omega / kTwoPi)) /
            std::abs(out.Y));
    }
    dwell.phasors.push_back(std::move(out));
  }
  report_relative_phases(rig, channels, omega, dwell);
}

void report_elements(const Rig& rig, const Eigen::MatrixXd& G, const std::vector<ChannelResult>& channels, double omega,
                     double u_omega, std::span<const SeenMode> seen, Dwell& dwell) {
  std::vector<Evidence> evidence(channels.size());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const HarmonicFit& fit = channels[c].fit;
    evidence[c].reason = reason_of(channels[c]);
    evidence[c].usable = evidence[c].reason.empty();
    evidence[c].X = fit.X;
    evidence[c].covariance = fit.covariance;
    evidence[c].dof = channels[c].dof;
    evidence[c].widened = channels[c].scatter.widens();
    evidence[c].stretches = channels[c].stretches;
    evidence[c].slope = channels[c].slope;
    evidence[c].taken_for_transient = channels[c].taken_for_transient;
    evidence[c].transient = channels[c].transient;
    evidence[c].quantization_u = channels[c].quantization_u;
    evidence[c].refresh_u_s = channels[c].refresh_u_s;
    evidence[c].uneven = channels[c].uneven;
    evidence[c].folded_u = channels[c].folded_u;
    evidence[c].turnaround_u_s = channels[c].turnaround_u_s;
    evidence[c].transaction = channels[c].transaction;
  }
  const Gain gain = solve_observation(G, observation_weights(rig, evidence, omega));
  for (Doubt& doubt : twin_channels(rig, channels)) dwell.doubts.push_back(std::move(doubt));
  for (Doubt& doubt : contradictions(rig, G, gain, evidence, omega)) dwell.doubts.push_back(std::move(doubt));
  ElementsResult result = estimate_elements(rig, gain, evidence, {omega, u_omega, rig.excitation.clock_u});
  check_modes(rig, result, omega, seen, dwell);
  dwell.elements = std::move(result.elements);
  dwell.covariance = std::move(result.covariance);
  for (const SourceEffect& effect : result.effects)
    dwell.errors.push_back({{effect.on_coefficients.begin(), effect.on_coefficients.end()},
                            effect.mass,
                            effect.mass_u,
                            effect.clock_u,
                            effect.readings});
  for (Doubt& doubt : result.doubts) dwell.doubts.push_back(std::move(doubt));
  for (Warning& warning : result.warnings) dwell.warnings.push_back(std::move(warning));
}

}  // namespace dwell
