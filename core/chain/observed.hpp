// Converts a transducer's reading to the displacement, or the force on the ground, that it observes.
//
// A reading X of a motion exp(st) is X = T(s)·o. T contains the derivative that the transducer measures, its filters
// and its delay (core/rig/transducer.hpp); o is the displacement or the force (core/rig/observation.hpp). All functions
// are thread-safe and not real-time safe.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/chain/evidence.hpp"
#include "core/result/coefficient_error.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Converts X, the channel's phasor at h·omega (rad/s), to o; both SI.
[[nodiscard]] std::complex<double> as_observed(const Rig& rig, int channel, std::complex<double> X, double omega,
                                               int h);

// The same for a motion exp(st), s in rad/s: amplitude a of a natural oscillation with the pole s.
[[nodiscard]] std::complex<double> as_observed(const Rig& rig, int channel, std::complex<double> a,
                                               std::complex<double> s);

// Part by which o is too small for a motion exp(st), s in rad/s, given an error of the reading.
[[nodiscard]] std::complex<double> observed_too_small(const Rig& rig, const ReadingError& error,
                                                      std::complex<double> s);

// Weights for solve_observation(): 1/u(o) by noise and scale_u at the present phasors; 0 for a channel not usable.
[[nodiscard]] Eigen::VectorXd observation_weights(const Rig& rig, const std::vector<Evidence>& evidence, double omega);

}  // namespace dwell
