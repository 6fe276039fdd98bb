// From a transducer's reading to what the chain shows there: displacement, or force on the ground.
//
// A reading X of the motion exp(st) is X = T(s)·o: T has the derivative that the transducer measures, its filters and
// its delay (core/rig/transducer.hpp), o is the displacement or the force (core/rig/observation.hpp). All functions are
// thread-safe and not real-time safe.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/chain/evidence.hpp"
#include "core/result/coefficient_error.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// The channel's reading turned into what the chain sees: displacement or force on the ground, harmonic h of omega.
[[nodiscard]] std::complex<double> as_observed(const Rig& rig, int channel, std::complex<double> X, double omega,
                                               int h);

// The same of a motion exp(st), s in rad/s: amplitude a of a natural oscillation with the pole s.
[[nodiscard]] std::complex<double> as_observed(const Rig& rig, int channel, std::complex<double> a,
                                               std::complex<double> s);

// By what part of itself the channel observes too little of a motion exp(st), s in rad/s.
[[nodiscard]] std::complex<double> observed_too_small(const Rig& rig, const ReadingError& error,
                                                      std::complex<double> s);

// Weights 1/u of each channel for solve_observation, from noise and scale at the present phasors; 0 where not usable.
[[nodiscard]] Eigen::VectorXd observation_weights(const Rig& rig, const std::vector<Evidence>& evidence, double omega);

}  // namespace dwell
