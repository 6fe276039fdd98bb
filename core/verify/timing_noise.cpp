#include "core/verify/timing_noise.hpp"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/base/instants.hpp"
#include "core/verify/verification_stretch.hpp"

namespace dwell {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Least readings for each unknown of the harmonics: the residuals are then no more than an eighth smaller than the
// noise.
constexpr Index kReadingsPerUnknown = 8;

// v² at each reading, from its two neighbours: the reading's own error is not in it.
ArrayXd squared_velocity(const ChannelReadings& readings) {
  const auto count = static_cast<Index>(readings.value.size());
  ArrayXd out = ArrayXd::Zero(count);
  if (count < 3) return out;
  for (Index i = 1; i + 1 < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double velocity =
        (readings.value[at + 1] - readings.value[at - 1]) / to_s(readings.t_ns[at + 1] - readings.t_ns[at - 1]);
    out(i) = velocity * velocity;
  }
  out(0) = out(1);
  out(count - 1) = out(count - 2);
  return out;
}

// What the harmonics of omega and a mean leave of the readings.
VectorXd residuals(const ChannelReadings& readings, double omega, int harmonics) {
  const auto count = static_cast<Index>(readings.value.size());
  MatrixXd basis(count, 2 * harmonics + 1);
  for (Index i = 0; i < count; ++i) {
    const double phase = omega * to_s(readings.t_ns[static_cast<std::size_t>(i)] - readings.t_ns.front());
    basis(i, 0) = 1.0;
    for (int k = 1; k <= harmonics; ++k) {
      basis(i, 2 * k - 1) = std::cos(k * phase);
      basis(i, 2 * k) = std::sin(k * phase);
    }
  }
  const auto value = Eigen::Map<const VectorXd>(readings.value.data(), count);
  return value - basis * basis.colPivHouseholderQr().solve(value);
}

}  // namespace

TimingNoise timing_noise_of(const ChannelReadings& steady, double omega, int harmonics) {
  TimingNoise out;
  const auto count = static_cast<Index>(steady.value.size());
  if (count < kReadingsPerUnknown * (2 * harmonics + 1)) return out;
  const ArrayXd velocity2 = squared_velocity(steady);
  const ArrayXd squares = residuals(steady, omega, harmonics).array().square();
  const double mean_velocity2 = velocity2.mean(), variance = squares.mean();
  if (!(mean_velocity2 > 0 && variance > 0)) return out;
  const ArrayXd more = velocity2 / mean_velocity2 - 1;  // s_i - 1
  const double spread = more.square().sum();
  if (!(spread > 0)) return out;
  const double slope = (more * (squares / variance - 1)).sum() / spread;
  out.part = std::clamp(slope, 0.0, 1.0);
  // The variance is estimated from the same residuals, so their scatter moves it as well.
  const ArrayXd off = squares / variance - 1 - slope * more;
  out.u = std::sqrt(((more - slope * spread / static_cast<double>(count)) * off).square().sum()) / spread;
  out.steady_velocity2 = mean_velocity2;
  return out;
}

std::vector<double> TimingNoise::relative_to_steady(const ChannelReadings& readings) const {
  std::vector<double> out(readings.value.size(), 1.0);
  if (part == 0.0) return out;
  const ArrayXd velocity2 = squared_velocity(readings);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = std::sqrt(1 - part + part * velocity2(static_cast<Index>(i)) / steady_velocity2);
  return out;
}

double TimingNoise::mean_square_velocity(const ChannelReadings& readings) const {
  if (steady_velocity2 == 0.0 || readings.value.empty()) return 1.0;
  return squared_velocity(readings).mean() / steady_velocity2;
}

}  // namespace dwell
