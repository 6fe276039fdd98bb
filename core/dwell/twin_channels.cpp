#include "core/dwell/twin_channels.hpp"

#include <cmath>
#include <complex>
#include <optional>
#include <string>

#include "core/base/chance.hpp"
#include "core/base/wording.hpp"

namespace dwell {
namespace {

// The same signal read twice differs by noise alone: by more than three standard deviations in one of 370 cases, of the
// mean and of the phasor (χ² of two degrees of freedom above 11.8). Smaller: more twins go unseen.
constexpr double kSamePhasor = 11.8;
// How often the means of two transducers may agree so well by chance, if that of one lies anywhere up to that of the
// other on either side. Larger: healthy channels on both sides of a stiff element are doubted more often.
constexpr double kByChance = 1e-3;

// In the device's own numbers.
struct Reading {
  double mean, u2_mean;
  std::complex<double> X;
  Eigen::Matrix2d covariance;
};

std::optional<Reading> reading_of(const Channel& channel, const ChannelResult& result) {
  const HarmonicFit& fit = result.fit;
  if (!result.withheld.empty() || !fit.usable || channel.measures == Quantity::auxiliary) return std::nullopt;
  const double si_per_number = channel.si_per_unit * channel.scale;
  const double squared = si_per_number * si_per_number / result.scatter.widens();
  return Reading{(fit.mean / channel.si_per_unit - channel.offset) / channel.scale, fit.sigma2 / fit.samples / squared,
                 fit.X[0] / si_per_number, fit.covariance / squared};
}

std::string mean_text(const Reading& reading) {
  std::string text = plus_minus(reading.mean, 2 * std::sqrt(reading.u2_mean), "");
  text.pop_back();  // the space before the unit: the device's numbers have none
  return text;
}

bool are_twins(const Reading& a, const Reading& b) {
  const double u_mean = std::sqrt(a.u2_mean + b.u2_mean);
  if (!(std::abs(a.mean - b.mean) <= sigmas::kNoise * u_mean)) return false;
  if (!(sigmas::kNoise * u_mean < kByChance * std::abs(a.mean))) return false;
  const std::complex<double> apart = a.X - b.X;
  const Eigen::Vector2d d(apart.real(), apart.imag());
  const Eigen::Matrix2d covariance = a.covariance + b.covariance;
  return d.dot(covariance.inverse() * d) <= kSamePhasor;
}

}  // namespace

std::vector<Doubt> twin_channels(const Rig& rig, std::span<const ChannelResult> channels) {
  std::vector<std::optional<Reading>> readings;
  for (std::size_t c = 0; c < channels.size(); ++c) readings.push_back(reading_of(rig.channels[c], channels[c]));
  std::vector<Doubt> doubts;
  for (std::size_t a = 0; a < readings.size(); ++a)
    for (std::size_t b = a + 1; b < readings.size(); ++b) {
      const Channel &one = rig.channels[a], &other = rig.channels[b];
      const bool same_place =
          one.measures == other.measures && one.at == other.at && one.relative_to == other.relative_to;
      if (same_place || !readings[a] || !readings[b] || !are_twins(*readings[a], *readings[b])) continue;
      doubts.push_back({{},
                        one.name + " and " + other.name + " read the same: the device's numbers are " +
                            mean_text(*readings[a]) + " and " + mean_text(*readings[b]) +
                            " in the mean, and swing alike within noise. Do both channels show one transducer?"});
    }
  return doubts;
}

}  // namespace dwell
