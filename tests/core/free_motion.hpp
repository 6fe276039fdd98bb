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
#include "core/transient/chain_poles.hpp"
#include "core/transient/foreign_lines.hpp"
#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/hold_refit.hpp"
#include "core/transient/knock_watch.hpp"
#include "core/transient/pole_search.hpp"
#include "core/transient/residual_noise.hpp"

namespace dwell {

struct FreeMotion {
  static constexpr double kDrive = kTwoPi * 5.0, kPeriodLength_s = 0.2, kSamples_hz = 400.0, kRms = 1e-3;
  static constexpr Complex kMode{-0.5, 33.0};

  SampleHistory history{std::size_t{1} << 16};
  std::vector<FittedChannel> channels{2};
  HoldFit fit{history, 2, 1, 6, {}};
  ResidualNoise noise{2};
  double seconds = 0.0, instant_u_s = 0.0;  // both channels are read that much earlier or later than stamped
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
    for (int i = from; i < static_cast<int>(std::lround(seconds * kSamples_hz)); ++i) {
      const double t = i / kSamples_hz + (instant_u_s > 0 ? instant_u_s * normal(random) : 0.0);
      for (int c = 0; c < 2; ++c)
        history.push(to_ns(i / kSamples_hz), c,
                     std::sin(kDrive * t + c) + (mode * (c + 1) * std::exp(kMode * t)).real() + beside(c, t) +
                         kRms * normal(random));
    }
  }
  void learn_noise() {
    const double variance = kRms * kRms + 0.5 * std::pow(kDrive * instant_u_s, 2);
    for (int c = 0; c < 2; ++c) noise.learn(c, 400 * variance, 400);
  }
  [[nodiscard]] HoldNow now() const { return {to_ns(seconds), 0, kDrive, true, 0, channels}; }
  // The fit of all since from_s by these poles; its misfit.
  double fit_all(double from_s, std::span<const Complex> poles) {
    fit.begin_at(to_ns(from_s));
    fit.measure_ranges(channels);
    return fit.anew(kDrive, poles, channels);
  }
};

// A chain that says always the same of its poles.
class StatedPoles final : public ChainPoles {
 public:
  explicit StatedPoles(std::vector<Complex> poles) : poles_(std::move(poles)) {}
  [[nodiscard]] std::span<const Complex> seen_by(const ModalFit&) noexcept override { return poles_; }
  [[nodiscard]] std::span<const Complex> last() const noexcept override { return poles_; }

 private:
  std::vector<Complex> poles_;
};

inline Rig rig_of_one_mass() {
  Rig rig;
  rig.masses = {1.0};
  rig.excitation.frequency_hz = 5.0;
  rig.excitation.search_low_hz = 4.9;
  rig.excitation.search_high_hz = 5.1;
  return rig;
}

// The same with all that looks for the poles.
struct SearchedMotion : FreeMotion {
  Rig rig = rig_of_one_mass();
  StatedPoles chain;
  KnockWatch knocks{2};
  PoleSearch search{rig, fit, noise};
  ForeignLines lines{search, fit, noise, 1};
  HoldRefit refit{{chain, fit, noise, knocks, search, lines}, 1};

  SearchedMotion(std::uint64_t seed, std::vector<Complex> stated) : FreeMotion(seed), chain(std::move(stated)) {}

  // Begins the fit at from_s by these poles, first those of `beside`.
  double begin(double from_s, const std::vector<Complex>& beside, const std::vector<Complex>& of_chain) {
    search.poles().beside = beside;
    search.poles().chain = of_chain;
    search.best() = beside;
    search.best().insert(search.best().end(), of_chain.begin(), of_chain.end());
    fit.allow(1000);
    return fit_all(from_s, search.best());
  }
  [[nodiscard]] bool explained() const { return noise.explained(fit.fit(), now()); }
};

}  // namespace dwell
