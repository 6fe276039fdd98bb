// A hold for the tests of core/transient: steady motion, natural oscillations and noise in two channels, sampled at
// 400 Hz. Channel 0 may be made the table's.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include "core/base/complex.hpp"
#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/residual_noise.hpp"

namespace dwell {

struct FreeMotion {
  static constexpr double kDrive = kTwoPi * 5.0, kPeriodLength_s = 0.2, kSamples_hz = 400.0, kRms = 1e-3;
  static constexpr Complex kMode{-0.5, 33.0};

  SampleHistory history{std::size_t{1} << 16};
  std::vector<FittedChannel> channels{2};
  HoldFit fit{history, 2, 1, 6, {}};
  ResidualNoise noise{2};
  double seconds = 0.0;
  std::mt19937_64 random;
  std::normal_distribution<double> normal;

  explicit FreeMotion(std::uint64_t seed) : random(seed) {
    for (FittedChannel& channel : channels) channel.watched = true;
  }

  // What swings beside the steady motion and kMode, by channel and time, s.
  using Beside = std::function<double(int, double)>;
  static double nothing(int, double) { return 0.0; }

  // So much more of the motion, as samples and as stretches of noise that the pipeline would have learned from.
  void play(double more_s, const Beside& beside = nothing, double mode = 0.3) {
    const auto from = static_cast<int>(std::lround(seconds * kSamples_hz));
    seconds += more_s;
    for (int i = from; i < static_cast<int>(std::lround(seconds * kSamples_hz)); ++i)
      for (int c = 0; c < 2; ++c) {
        const double t = i / kSamples_hz;
        history.push(to_ns(t), c,
                     std::sin(kDrive * t + c) + (mode * (c + 1) * std::exp(kMode * t)).real() + beside(c, t) +
                         kRms * normal(random));
      }
  }
  void learn_noise() {
    for (int c = 0; c < 2; ++c) noise.learn(c, 400 * kRms * kRms, 400);
  }
  [[nodiscard]] HoldNow now() const { return {to_ns(seconds), 0, kDrive, true, 0, channels}; }
  // The fit of all since from_s by these poles; its misfit.
  double fit_all(double from_s, std::span<const Complex> poles) {
    fit.begin_at(to_ns(from_s));
    fit.measure_ranges(channels);
    return fit.anew(kDrive, poles, channels);
  }
};

}  // namespace dwell
