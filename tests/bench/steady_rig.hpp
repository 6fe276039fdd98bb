// The rig that the benches measure: seven masses on a table, free, driven at 10 Hz, a transducer at the table and at
// every mass, all in the steady state. The readings are those of the exact steady response, so that ten minutes of them
// are made within a second.
#pragma once

#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {

class SteadyRig {
 public:
  static constexpr double kFrequency_hz = 10.0;
  static constexpr double kRate_hz = 1000.0;   // per channel
  static constexpr double kAmplitude = 0.002;  // m, the table's
  static constexpr double kNoise = 1e-6;       // m

  // The same chain and the same noise each time.
  SteadyRig() {
    std::mt19937_64 chain_rng(1);
    const Chain chain = random_chain(chain_rng, 7, Boundary::free, kFrequency_hz);
    rig_ = rig_of(chain, kFrequency_hz);
    Y_ = steady_response(chain, kOmega, {kAmplitude, 0.0}).Y;
  }

  [[nodiscard]] const Rig& rig() const { return rig_; }
  [[nodiscard]] int channels() const { return static_cast<int>(Y_.size()); }

  // What channel c reads at t_s, m.
  double reading(int c, double t_s) {
    const Phasor& Y = Y_[static_cast<std::size_t>(c)];
    return std::abs(Y) * std::sin(kOmega * t_s + std::arg(Y)) + kNoise * normal_(rng_);
  }

 private:
  static constexpr double kOmega = 2 * M_PI * kFrequency_hz;

  Rig rig_;
  std::vector<Phasor> Y_;  // one per channel, m
  std::mt19937_64 rng_{2};
  std::normal_distribution<double> normal_;
};

}  // namespace dwell
