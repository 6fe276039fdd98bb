#include "core/report.hpp"

#include <cmath>
#include <numbers>

#include "core/transducer.hpp"

namespace dwell {
namespace {
constexpr double kTwoPi = 2 * std::numbers::pi;

std::string reason_of(const ChannelResult& channel) {
  if (!channel.withheld.empty()) return channel.withheld;
  return channel.fit.usable ? "" : "too few samples in the data that count";
}
}  // namespace

void report_phasors(const Rig& rig, const std::vector<ChannelResult>& channels, double omega, double u_omega,
                    Dwell& dwell) {
  const int H = rig.excitation.harmonics;
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
      // The covariance along the phasor and across it.
      const Eigen::Vector2d along(X.real() / amplitude, X.imag() / amplitude), across(-along(1), along(0));
      const double u_along = std::sqrt(along.dot(fit.covariance * along)) / amplitude;
      const double u_across = std::sqrt(across.dot(fit.covariance * across)) / amplitude;
      out.u_amplitude =
          std::abs(out.Y) * std::hypot(u_along, std::hypot(channel.scale_u, channels[c].transient_u / amplitude,
                                                           channels[c].quantization_u / amplitude));
      out.u_phase_rad =
          std::hypot(u_across, std::hypot(channels[c].transient_u, channels[c].quantization_u) / amplitude,
                     omega * std::hypot(channel.delay_u_s, device.delay_u_s, channels[c].turnaround_u_s));
      for (int h = 2; h <= H; ++h)
        out.harmonics.push_back(
            std::abs(fit.X[static_cast<std::size_t>(h - 1)] / response(channel, device.delay_s, h * omega / kTwoPi)) /
            std::abs(out.Y));
    }
    dwell.phasors.push_back(std::move(out));
  }
}

void report_elements(const Rig& rig, const Eigen::MatrixXd& G, const std::vector<ChannelResult>& channels, double omega,
                     double u_omega, Dwell& dwell) {
  std::vector<Evidence> evidence(channels.size());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const HarmonicFit& fit = channels[c].fit;
    evidence[c].reason = reason_of(channels[c]);
    evidence[c].usable = evidence[c].reason.empty();
    evidence[c].X = fit.X;
    evidence[c].covariance = fit.covariance;
    evidence[c].dof = channels[c].dof;
    evidence[c].transient_u = channels[c].transient_u;
    evidence[c].quantization_u = channels[c].quantization_u;
    evidence[c].turnaround_u_s = channels[c].turnaround_u_s;
  }
  const Gain gain = solve_observation(G, observation_weights(rig, evidence, omega));
  ElementsResult result = estimate_elements(rig, gain, evidence, {omega, u_omega, rig.excitation.clock_u});
  dwell.elements = std::move(result.elements);
  dwell.covariance = std::move(result.covariance);
  for (std::string& warning : result.warnings) dwell.warnings.push_back(std::move(warning));
}

}  // namespace dwell
