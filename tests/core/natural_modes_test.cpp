#include "core/model/natural_modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/complex.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

Complex nearest(const Chain& chain, Complex pole) {
  const auto values = natural_values(chain);
  return *std::min_element(values.begin(), values.end(),
                           [&](Complex a, Complex b) { return std::abs(a - pole) < std::abs(b - pole); });
}

// (λ(1 + h) - λ(1 - h)) / 2h of one coefficient, times nothing: per relative change.
Complex difference(const Chain& chain, std::vector<double> Chain::*of, std::size_t i, Complex pole) {
  constexpr double kStep = 1e-5;
  Chain more = chain, less = chain;
  (more.*of)[i] *= 1 + kStep;
  (less.*of)[i] *= 1 - kStep;
  return (nearest(more, pole) - nearest(less, pole)) / (2 * kStep);
}

TEST(NaturalModes, MoveAsDifferencesOfTheEigenvaluesSay) {
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Chain chain = random_chain(rng, 1 + trial % 4, trial % 2 ? Boundary::clamped : Boundary::free, 4.0);
    for (const NaturalMode& mode : natural_modes(chain)) {
      const double close = 1e-6 * std::abs(mode.pole);
      EXPECT_LT(std::abs(nearest(chain, mode.pole) - mode.pole), 1e-9 * std::abs(mode.pole));
      for (std::size_t e = 0; e < chain.stiffness.size(); ++e) {
        const Complex by = mode.by_stiffness(static_cast<Eigen::Index>(e));
        EXPECT_LT(std::abs(difference(chain, &Chain::stiffness, e, mode.pole) - by * chain.stiffness[e]), close);
        EXPECT_LT(std::abs(difference(chain, &Chain::damping, e, mode.pole) - mode.pole * by * chain.damping[e]),
                  close);
      }
      for (std::size_t k = 0; k < chain.masses.size(); ++k)
        EXPECT_LT(std::abs(difference(chain, &Chain::masses, k, mode.pole) -
                           mode.by_mass(static_cast<Eigen::Index>(k)) * chain.masses[k]),
                  close);
    }
  }
}

}  // namespace
}  // namespace dwell
