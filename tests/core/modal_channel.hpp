// One channel of the modal fit with all that its parts need, for their tests: 3 + 2 sin ωu + decaying modes + noise.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <random>
#include <vector>

#include "core/transient/linear_part.hpp"
#include "core/transient/modal_regressors.hpp"
#include "core/transient/shared_sums.hpp"

namespace dwell {

struct ModalChannel {
  static constexpr int kHarmonics = 1, kMost = 3;
  static constexpr double kOmega = 2 * M_PI * 5.0, kRate_hz = 200.0;
  using Poles = std::vector<std::complex<double>>;

  // The motion that was and its amplitudes; the fit is told `told`.
  struct Truth {
    Poles poles, amplitudes;
    double noise, seconds;
    double omega = kOmega;
  };
  ModalChannel(const Truth& truth, const Poles& told, std::uint64_t seed = 1) {
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    regressors.restart(kOmega, 0.0, 0, told);
    for (int i = 0; i < truth.seconds * kRate_hz; ++i) {
      const std::int64_t t_ns = 5'000'000LL * i;
      const double u = 1e-9 * static_cast<double>(t_ns);
      double value = 3 + 2 * std::sin(truth.omega * u) + truth.noise * normal(rng);
      for (std::size_t m = 0; m < truth.poles.size(); ++m)
        value += (truth.amplitudes[m] * std::exp(truth.poles[m] * u)).real();
      sums_.add(0, static_cast<std::uint64_t>(i) + 1, regressors.at(t_ns), layout().all(), value);
    }
    sums_.complete(0, layout().all());
  }
  bool solve(double range = 10.0) { return linear.solve(layout(), motion(), sums, range, range, solution); }
  bool eliminate() {
    const double ridge = 1e-9 * sums.samples();
    return linear.eliminate(layout(), motion(), sums, ridge, ridge);
  }
  [[nodiscard]] const ModalLayout& layout() const { return regressors.layout(); }
  [[nodiscard]] const ModalMotion& motion() const { return regressors.motion(); }

  ModalRegressors regressors{kHarmonics, kMost};
  SharedSums sums_{1, ModalLayout{kHarmonics, kMost}.all()};
  ModalSums sums = sums_.of(0);
  LinearPart linear{kHarmonics, kMost};
  ModalSolution solution{kHarmonics, kMost};
};

}  // namespace dwell
