#include "core/chain/contradiction.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/rounding.hpp"
#include "core/base/student.hpp"
#include "core/base/wording.hpp"
#include "core/chain/chain_state.hpp"
#include "core/chain/identify.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;

struct Observed {
  Eigen::VectorXcd o;   // displacement or force on the ground
  Eigen::VectorXd own;  // variance by the errors of each channel alone, sum of both components
  // Change of o by one standard deviation of an instant that channels share, by what it is and by the index of the
  // device, of the transaction or of the channel that names the group.
  std::map<std::pair<SourceKind, int>, Eigen::VectorXcd> late;
};

Observed observed(const Rig& rig, const std::vector<Evidence>& evidence, double omega) {
  const auto count = static_cast<Index>(evidence.size());
  const Eigen::VectorXcd nothing = Eigen::VectorXcd::Zero(count);
  Observed out{nothing, Eigen::VectorXd::Zero(count), {}};
  for (Index c = 0; c < count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const Evidence& of = evidence[i];
    if (!of.usable) continue;
    const Channel& channel = rig.channels[i];
    const Device device = channel.device >= 0 ? rig.devices[static_cast<std::size_t>(channel.device)] : Device{};
    const Complex per_reading = as_observed(rig, static_cast<int>(c), 1.0, omega, 1);
    const LogSlopes slopes = response_slopes(channel, device.delay_s, omega / kTwoPi);
    const double few = std::pow(student_t95(of.dof) / kNormal95, 2);  // the noise estimate is itself uncertain
    out.o(c) = of.X[0] * per_reading;
    out.own(c) =
        std::norm(per_reading) * (few * few * (of.widened * of.covariance.trace() + of.transient.trace()) +
                                  2 * (of.quantization_u * of.quantization_u + of.folded_u * of.folded_u)) +
        std::norm(out.o(c)) * (channel.scale_u * channel.scale_u + of.uneven.part * of.uneven.part +
                               std::pow(omega * std::hypot(channel.delay_u_s, of.refresh_u_s, of.uneven.own_s), 2) +
                               std::norm(slopes.lowpass_corner * channel.lowpass.hz_u) +
                               std::norm(slopes.highpass_corner * channel.highpass.hz_u));
    const Complex delayed = Complex{0.0, omega} * out.o(c);
    if (device.delay_u_s > 0)
      out.late.try_emplace({SourceKind::delay, channel.device}, nothing).first->second(c) = delayed * device.delay_u_s;
    if (of.turnaround_u_s > 0)
      out.late.try_emplace({SourceKind::turnaround, std::max(of.transaction, 0)}, nothing).first->second(c) =
          delayed * of.turnaround_u_s;
    if (of.uneven.with >= 0)
      out.late.try_emplace({SourceKind::uneven, of.uneven.with}, nothing).first->second(c) =
          delayed * of.uneven.shared_s;
  }
  return out;
}

std::vector<int> elements_using(const Rig& rig, const Gain& gain, const std::vector<Index>& channels, double omega) {
  const ChainState chain{rig, rig.mass_count(), omega, {}};
  std::vector<int> out;
  for (int k = 1; k <= rig.element_count(); ++k)
    if (std::any_of(channels.begin(), channels.end(), [&](Index c) {
          return gain.uses(chain.force_row(k), c) || gain.uses(chain.deformation_row(k), c);
        }))
      out.push_back(k);
  return out;
}

}  // namespace

std::vector<Doubt> contradictions(const Rig& rig, const Eigen::MatrixXd& G, const Gain& gain,
                                  const std::vector<Evidence>& evidence, double omega) {
  const Observed seen = observed(rig, evidence, omega);
  const Index count = G.rows();
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(count, count) - G * gain.gain;
  const Eigen::VectorXcd left = rest * seen.o;
  std::vector<Index> off;
  std::vector<std::string> names, figures;
  for (Index c = 0; c < count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const Channel& channel = rig.channels[i];
    if (!evidence[i].usable || channel.measures == Quantity::auxiliary) continue;
    double variance = rest.row(c).cwiseAbs2().dot(seen.own);
    for (const auto& [shared, on_o] : seen.late) variance += std::norm((rest.row(c) * on_o)(0));
    // Largest reading of the same quantity: the rounding of a force does not reach a displacement.
    double largest = 0.0;
    for (Index other = 0; other < count; ++other)
      if (rest(c, other) != 0) largest = std::max(largest, std::abs(seen.o(other)));
    // One source, a scale, may be the whole difference: so the normal law holds.
    if (!(std::abs(left(c)) > sigmas::kSure * std::sqrt(variance) + kOnlyRounding * largest)) continue;
    const bool force = channel.measures == Quantity::force, turns = rig.motion == Motion::rotation;
    const std::string unit = force ? (turns ? "N·m" : "N") : (turns ? "rad" : "m");
    off.push_back(c);
    names.push_back(channel.name);
    figures.push_back(channel.name + " by " + brief(std::abs(left(c))) + " " + unit + " (" +
                      brief(100 * std::abs(left(c) / seen.o(c)), 2) + " %; allowed are " +
                      brief(kNormal95 * std::sqrt(variance), 2) + " " + unit + ")");
  }
  if (off.empty()) return {};
  if (figures.size() > kNamedAtMost) figures.resize(kNamedAtMost);
  Doubt doubt;
  doubt.elements = elements_using(rig, gain, off, omega);
  doubt.what = listed(names) + " contradict" + (off.size() == 1 ? "s" : "") +
               " the other transducers of the same motion, " + listed(figures) +
               ". Check scale, unit, delay and place, and state scale_u and delay_u; " + elements_text(doubt.elements) +
               (doubt.elements.size() == 1 ? " is" : " are") + " computed from them";
  return {doubt};
}

}  // namespace dwell
