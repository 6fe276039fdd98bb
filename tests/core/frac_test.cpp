#include "core/verify/frac.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "core/base/angle.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

// A dwell of a clamped chain whose table moves by 3 mm; the phasors of its channels times `factor`.
Dwell dwell_of(const Chain& chain, const Rig& rig, double f_hz, double factor = 1.0) {
  const std::complex<double> s{0.0, kTwoPi * f_hz};
  const SteadyResponse response = steady_response(chain, kTwoPi * f_hz, {0.003, 0.001});
  Dwell dwell;
  dwell.settled_s = 1.0;
  dwell.frequency_hz.value = f_hz;
  for (const Channel& channel : rig.channels) {
    ChannelPhasor phasor;
    phasor.valid = true;
    if (channel.measures == Quantity::force)
      phasor.Y = (channel.force_on_mass ? -1.0 : 1.0) * response.F;
    else
      phasor.Y = response.Y[static_cast<std::size_t>(channel.at)] * (channel.measures == Quantity::velocity ? s : 1.0);
    if (channel.at != 0) phasor.Y *= factor;
    dwell.phasors.push_back(phasor);
  }
  return dwell;
}

Rig velocity_rig() {
  Rig rig = rig_of(clamped_chain(), 4.0);
  rig.channels[1].measures = Quantity::velocity;
  rig.channels[3].force_on_mass = true;
  return rig;
}

TEST(Frac, IsOneOfTheRightChainAndBlindToACommonFactor) {
  const Rig rig = velocity_rig();
  for (const double factor : {1.0, 0.8}) {
    const Dwell a = dwell_of(clamped_chain(), rig, 3.0, factor), b = dwell_of(clamped_chain(), rig, 5.0, factor),
                c = dwell_of(clamped_chain(), rig, 7.0, factor);
    for (const double value : frac(rig, clamped_chain(), {&a, &b, &c})) EXPECT_NEAR(value, 1.0, 1e-12);
  }
}

TEST(Frac, FallsWhereTheShapeOverFrequencyIsAnother) {
  const Rig rig = velocity_rig();
  Chain wrong = clamped_chain();
  wrong.masses[0] *= 1.5;
  const Dwell a = dwell_of(clamped_chain(), rig, 3.0), b = dwell_of(clamped_chain(), rig, 7.0);
  EXPECT_LT(frac(rig, wrong, {&a, &b})[1], 0.99);
}

TEST(Frac, IsNoneOfASingleFrequency) {
  const Rig rig = velocity_rig();
  const Dwell a = dwell_of(clamped_chain(), rig, 5.0), same = dwell_of(clamped_chain(), rig, 5.04);
  for (const double value : frac(rig, clamped_chain(), {&a, &same})) EXPECT_TRUE(std::isnan(value));
  Dwell other = dwell_of(clamped_chain(), rig, 7.0);
  other.phasors[2].valid = false;
  const std::vector<double> values = frac(rig, clamped_chain(), {&a, &other});
  EXPECT_TRUE(std::isnan(values[2]));
  EXPECT_FALSE(std::isnan(values[1]));
}

}  // namespace
}  // namespace dwell
