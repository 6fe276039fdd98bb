#include "core/verify/frac.hpp"

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <cstddef>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Complex = std::complex<double>;

Complex derivative(const Channel& channel, double omega) {
  return std::pow(Complex{0.0, omega}, derivative_order(channel.measures));
}

// H_p per channel: the reading's phasor for a table displacement of 1.
std::vector<Complex> predicted(const Rig& rig, const Chain& chain, double omega) {
  const SteadyResponse response = steady_response(chain, omega, 1.0);
  const auto n = static_cast<Eigen::Index>(response.Y.size()) - 1;
  Eigen::VectorXcd x(n + 2);
  x(0) = response.Y[0];
  for (Eigen::Index k = 1; k <= n; ++k)
    x(k) = response.Y[static_cast<std::size_t>(k)] - response.Y[static_cast<std::size_t>(k - 1)];
  x(n + 1) = response.F;
  const Eigen::VectorXcd seen = observation_matrix(rig) * x;
  std::vector<Complex> out;
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    const Channel& channel = rig.channels[c];
    const Complex turn =
        channel.measures == Quantity::force ? (channel.force_on_mass ? -1.0 : 1.0) : derivative(channel, omega);
    out.push_back(turn * seen(static_cast<Eigen::Index>(c)));
  }
  return out;
}

// The table's displacement; NaN: no channel shows it.
Complex table_of(const Rig& rig, const Dwell& dwell, double omega) {
  for (std::size_t c = 0; c < rig.channels.size(); ++c)
    if (shows_drive(rig.channels[c]) && dwell.phasors[c].valid)
      return dwell.phasors[c].Y / derivative(rig.channels[c], omega);
  return {kNaN, kNaN};
}

struct FracSums {
  Complex both;
  double predicted = 0.0, measured = 0.0;
  std::vector<const Dwell*> dwells;
};

bool several_frequencies(const std::vector<const Dwell*>& dwells) {
  for (const Dwell* dwell : dwells)
    if (!same_frequency(*dwell, *dwells.front())) return true;
  return false;
}

}  // namespace

bool same_frequency(const Dwell& a, const Dwell& b) noexcept {
  return std::abs(a.frequency_hz.value - b.frequency_hz.value) < kSameFrequency * a.frequency_hz.value;
}

std::vector<double> frac(const Rig& rig, const Chain& chain, const std::vector<const Dwell*>& dwells) {
  std::vector<FracSums> sums(rig.channels.size());
  for (const Dwell* dwell : dwells) {
    const double omega = kTwoPi * dwell->frequency_hz.value;
    const Complex table = table_of(rig, *dwell, omega);
    const std::vector<Complex> H = predicted(rig, chain, omega);
    for (std::size_t c = 0; c < sums.size(); ++c) {
      const Complex measured = dwell->phasors[c].Y / table;
      if (!dwell->phasors[c].valid || !std::isfinite(std::abs(measured)) || !std::isfinite(std::abs(H[c]))) continue;
      sums[c].both += H[c] * std::conj(measured);
      sums[c].predicted += std::norm(H[c]);
      sums[c].measured += std::norm(measured);
      sums[c].dwells.push_back(dwell);
    }
  }
  std::vector<double> out;
  for (const FracSums& of : sums)
    out.push_back(several_frequencies(of.dwells) ? std::norm(of.both) / (of.predicted * of.measured) : kNaN);
  return out;
}

}  // namespace dwell
