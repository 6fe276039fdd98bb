// Predicted minus measured over a stretch, under one assumption about rig and chain; and what noise alone would make of
// it. The initial state is estimated by least squares from the part of the stretch that is not scored: the prediction
// is linear in it, by the free response of each initial condition. So noise of the table, of the readings, and through
// the initial state go one way, and draws of it show all three with their correlations (GUM Supplement 1, JCGM 101).
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "core/model/chain.hpp"
#include "core/result/coefficient_error.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/verification_stretch.hpp"
#include "core/verify/verification_table.hpp"

namespace dwell {

// The rig and chain assumed when the test is repeated. A source of error moves several members at once.
struct Assumption {
  Rig rig;
  Chain chain;
  std::vector<double> gain;  // per channel: readings are taken this many times as large
  double fast = 0.0;         // relative: the clock is taken to run fast by this

  Assumption(const Rig& the_rig, const Chain& the_chain)
      : rig(the_rig), chain(the_chain), gain(the_rig.channels.size(), 1.0) {}
  // The same with `part` standard deviations of that source: coefficients, masses, readings and clock together.
  [[nodiscard]] Assumption moved(const CoefficientError& error, double part) const;
};

// Draws of the noise of every reading: independent, with the standard deviations of the stretch; seeded, so that a
// verification gives the same bits again.
struct NoiseDraws {
  NoiseDraws(const VerificationStretch& stretch, Eigen::Index draws, std::uint64_t seed);
  std::vector<Eigen::MatrixXd> of_channel;  // per channel of the rig, draws × readings
  Eigen::Index draws;
};

// All compared channels' scored readings below each other, in the order of VerificationStretch::compared.
struct Residuals {
  std::string fault;  // why there are none ("the prediction diverges"); empty: there are
  Eigen::VectorXd predicted, measured;
  Eigen::VectorXd beyond_steady;  // predicted, less the part that the steady phasors predict
  // Of noise alone, a column per draw: the prediction; the prediction less the noise of the readings; beyond_steady.
  Eigen::MatrixXd noise_predicted, noise_error, noise_beyond_steady;

  [[nodiscard]] Eigen::VectorXd error() const { return predicted - measured; }
};

// Which readings of the table are interpolated: all, or every second from the given one on. The difference shows the
// error of interpolating.
enum class Knots : std::uint8_t { all, even, odd };

// ratio: per channel of the rig the steady phasor of its reading over that of the table's motion at omega (rad/s), for
// beyond_steady; empty: it is not wanted. draws: may be null. Allocates; O(readings · (draws + states) · states²).
struct SteadyRatio {
  std::vector<std::complex<double>> ratio;
  double omega = 0.0;
};
[[nodiscard]] Residuals residuals_of(const VerificationStretch& stretch, const SteadyTable& table,
                                     const Assumption& assumption, Knots knots = Knots::all,
                                     const NoiseDraws* draws = nullptr, const SteadyRatio* steady = nullptr);

}  // namespace dwell
