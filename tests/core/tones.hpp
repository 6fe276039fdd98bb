// A chain under a table that moves as a sum of tones, each answered by the chain's exact steady response: a drive whose
// amplitude or frequency hunts is a carrier with two sidebands.
#pragma once

#include <cmath>
#include <complex>
#include <functional>
#include <random>
#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {

struct Tone {
  double hz;
  std::complex<double> Y0;  // m
};

// y_0 = A (1 + a sin 2πFt) sin(2πft + b sin 2πFt), to first order in a and b.
inline std::vector<Tone> hunting(double hz, double amplitude, double by, double hunt_hz, double phase_rad = 0.0) {
  const std::complex<double> j{0.0, 1.0}, side = -0.5 * j * amplitude * std::complex<double>(by, phase_rad);
  const std::complex<double> other = 0.5 * j * amplitude * std::complex<double>(by, phase_rad);
  return {{hz, amplitude}, {hz + hunt_hz, side}, {hz - hunt_hz, other}};
}

// Streams the motion into a pipeline.
struct Toned {
  Chain chain;
  Rig rig;
  std::vector<Tone> tones;
  double rate_hz = 500.0, noise = 1e-3;  // of each channel's carrier
  std::mt19937_64 rng{1};
  std::int64_t played = 0;  // scans

  // Goes on with a pipeline for so long; `pushed` is told what each record changed.
  void play(Pipeline& pipeline, double seconds, const std::function<void(std::uint8_t)>& pushed,
            const std::function<double(double)>& factor = {}) {
    struct Heard {
      double omega;
      std::complex<double> X;
    };
    std::vector<std::vector<Heard>> heard(rig.channels.size());
    std::vector<double> sigma;
    for (const Tone& tone : tones) {
      const SteadyResponse response = steady_response(chain, 2 * M_PI * tone.hz, tone.Y0);
      for (std::size_t c = 0; c < heard.size(); ++c) {
        const std::complex<double> X = c < response.Y.size() ? response.Y[c] : response.F;
        heard[c].push_back({2 * M_PI * tone.hz, X});
        if (heard[c].size() == 1) sigma.push_back(noise * std::abs(X));
      }
    }
    std::normal_distribution<double> normal;
    for (const auto end = played + std::llround(seconds * rate_hz); played < end; ++played) {
      const double t_s = static_cast<double>(played) / rate_hz;
      for (std::size_t c = 0; c < heard.size(); ++c) {
        Record record;
        record.t_ns = std::llround(t_s * 1e9);
        record.channel = static_cast<std::uint16_t>(c);
        for (const Heard& tone : heard[c]) record.value += (tone.X * std::polar(1.0, tone.omega * t_s)).imag();
        if (factor) record.value *= factor(t_s);
        record.value += sigma[c] * normal(rng);
        pushed(pipeline.push(record));
      }
    }
  }

  // A recording of its own: the dwells that settled.
  std::vector<Dwell> run(double seconds, const std::function<double(double)>& factor = {}) const {
    Toned anew = *this;
    Pipeline pipeline(rig);
    std::vector<Dwell> dwells;
    const auto keep = [&](std::uint8_t changes) {
      if ((changes & kCompleted) && std::isfinite(pipeline.completed().settled_s))
        dwells.push_back(pipeline.completed());
    };
    anew.play(pipeline, seconds, keep, factor);
    keep(pipeline.finish());
    return dwells;
  }
};

}  // namespace dwell
