// The modes of the whole of a hold: what decays before the ordinary fit begins, and a bracket that rings beside them.
#include "core/transient/whole_hold.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "core/base/complex.hpp"

namespace dwell {
namespace {

constexpr double kHoldOmega = 2 * M_PI * 5.0, kHoldPeriod_s = 0.2, kHoldRate_hz = 400.0, kNoise = 1e-3;
constexpr Complex kSlow{-0.5, 33.0}, kFast{-20.0, 95.0};

// Two channels, a steady motion and what `beside` gives (channel, time since the hold began).
struct Hold {
  SampleHistory history{std::size_t{1} << 17};
  ModalFit latest{2, 1, 6};
  WholeHold whole{2, 1, 6, {}};
  std::vector<Complex> chain{kSlow, kFast};
  std::vector<char> imposed{0, 0};
  double seconds;

  Hold(const std::function<double(int, double)>& beside, std::uint64_t seed, double from_s = 2.0, double hold_s = 12.0)
      : seconds(hold_s) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (int i = 0; i < hold_s * kHoldRate_hz; ++i)
      for (int c = 0; c < 2; ++c) {
        const double t = i / kHoldRate_hz + 0.0007 * c;
        history.push(static_cast<std::int64_t>(std::llround(1e9 * t)), c,
                     std::sin(kHoldOmega * t + c) + beside(c, t) + kNoise * normal(random));
      }
    // The ordinary fit: it begins where the fast mode has gone.
    std::vector<Complex> poles{kSlow};
    for (int step = 0; step < 4; ++step) {
      latest.restart(kHoldOmega, 0.0, static_cast<std::int64_t>(1e9 * from_s), poles);
      for (auto n = history.first_at(latest.t0_ns()); n < history.end(); ++n)
        latest.add(history[n].channel, history[n].t_ns, history[n].value);
      for (int c = 0; c < 2; ++c) EXPECT_TRUE(latest.solve(c, 2.0, 2.0));
      latest.step_poles(0.05, 0.0);
      const auto moved = latest.moved_poles();
      poles.assign(moved.begin(), moved.end());
    }
  }

  [[nodiscard]] WholeHold::Given given() const {
    return {history, latest, chain, imposed, 0, static_cast<std::int64_t>(1e9 * seconds), kHoldPeriod_s, true};
  }
  // How many begins explained the data.
  int go() {
    int explained = 0;
    for (whole.begin(given()); whole.earlier(given());) ++explained;
    return explained;
  }
  // The seen pole next to one, and how far off it is in standard deviations.
  [[nodiscard]] double off(Complex truth) const {
    double nearest = INFINITY, u = 0.0;
    const auto poles = whole.fit().moved_poles();
    for (std::size_t m = 0; m < poles.size(); ++m)
      if (std::abs(poles[m] - truth) < nearest) nearest = std::abs(poles[m] - truth), u = whole.fit().u_pole(m);
    return nearest / u;
  }
};

double natural(Complex pole, Complex amplitude, double t) { return (amplitude * std::exp(pole * t)).real(); }

double healthy(int c, double t) {
  return natural(kSlow, c == 0 ? 0.4 : -0.3, t) + natural(kFast, c == 0 ? Complex{0.3, 0.2} : Complex{-0.2, 0.4}, t);
}

TEST(WholeHold, SeesAModeThatDecaysBeforeTheOrdinaryFitBegins) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Hold hold(healthy, seed);
    EXPECT_EQ(hold.latest.poles().size(), 1u);
    ASSERT_GT(hold.go(), 3) << seed;
    EXPECT_LT(hold.off(kFast), 4.0) << seed;
    EXPECT_LT(hold.off(kSlow), 4.0) << seed;
  }
}

// The check must not inherit what it checks: from a chain whose fast mode is 8 % and 40 % off the data's own is found.
TEST(WholeHold, FindsAModeThatTheIdentifiedChainHasElsewhere) {
  for (const Complex stated : {Complex{-24.0, 102.0}, Complex{-20.0, 133.0}}) {
    Hold hold(healthy, 3);
    hold.chain[1] = stated;
    ASSERT_GT(hold.go(), 3) << stated;
    EXPECT_LT(hold.off(kFast), 4.0) << stated;
  }
}

TEST(WholeHold, GivesABracketThatRingsAPoleOfItsOwn) {
  const Complex ring{-15.0, 110.0};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Hold hold([&](int c, double t) { return healthy(c, t) + (c == 0 ? natural(ring, 0.2, t) : 0.0); }, seed);
    ASSERT_GT(hold.go(), 3) << seed;
    EXPECT_LT(hold.off(kFast), 4.5) << seed;
    EXPECT_LT(hold.off(ring), 4.5) << seed;
  }
}

TEST(WholeHold, EndsWhereNoPolesExplainTheBeginning) {
  // The table is still on its way for three periods.
  Hold hold([](int c, double t) { return healthy(c, t) + 0.3 * std::max(0.0, 0.6 - t) * std::sin(40 * t * t); }, 5);
  const int explained = hold.go();
  EXPECT_GT(explained, 0);
  EXPECT_GE(1e-9 * static_cast<double>(hold.whole.fit().t0_ns()), 0.2);
  EXPECT_LT(hold.off(kSlow), 4.0);
}

TEST(WholeHold, APoleThatDoesNotShowStaysWhereTheChainHasIt) {
  Hold hold([](int c, double t) { return natural(kSlow, c == 0 ? 0.4 : -0.3, t); }, 6);
  ASSERT_GT(hold.go(), 3);
  const auto poles = hold.whole.fit().poles();
  EXPECT_EQ(poles.size(), 2u);
  EXPECT_TRUE(std::find(poles.begin(), poles.end(), kFast) != poles.end());
}

// Beyond what is affordable samples are left out at random; the poles are then known less well, and it says so.
TEST(WholeHold, OfALongHoldLeavesOutSamplesAndStaysRight) {
  Hold hold(healthy, 7, 2.0, 150.0);
  ASSERT_EQ(hold.history.begin(), 0u);
  ASSERT_GT(hold.go(), 3);
  EXPECT_LT(hold.whole.fit().samples(0), 0.9 * (150.0 - 0.05) * kHoldRate_hz);
  EXPECT_LT(hold.off(kFast), 4.0);
  EXPECT_LT(hold.off(kSlow), 4.0);
}

// Ten modes in 32 channels at 1 kHz: nine tenths of the samples are left out. What the fit left out differs from it by
// more than the noise, by the fit's own errors, and must not count against it.
TEST(WholeHold, OfManyChannelsLeavesOutMostSamplesAndStillExplainsTheBeginning) {
  constexpr int kChannels = 32, kModes = 10, kSeconds = 12;
  SampleHistory history{std::size_t{1} << 19};
  ModalFit latest{kChannels, 3, kModes};
  std::vector<Complex> chain;
  for (int m = 1; m <= kModes; ++m) chain.emplace_back(-0.3 * m * m, 7.0 + 13.0 * m);
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  for (int i = 0; i < kSeconds * 1000; ++i)
    for (int c = 0; c < kChannels; ++c) {
      const double t = 1e-3 * i + 1e-5 * c;
      double value = std::sin(kHoldOmega * t + c) + kNoise * normal(random);
      for (const Complex& pole : chain) value += natural(pole, {0.1 * std::cos(c + pole.imag()), 0.05}, t);
      history.push(static_cast<std::int64_t>(std::llround(1e9 * t)), c, value);
    }
  latest.restart(kHoldOmega, 0.0, 2'500'000'000, chain);
  for (auto n = history.first_at(latest.t0_ns()); n < history.end(); ++n)
    latest.add(history[n].channel, history[n].t_ns, history[n].value);
  for (int c = 0; c < kChannels; ++c) ASSERT_TRUE(latest.solve(c, 2.0, 2.0));

  const std::vector<char> imposed(kChannels, 0);
  const WholeHold::Given given{history, latest, chain, imposed, 0, kSeconds * 1'000'000'000LL, kHoldPeriod_s, true};
  WholeHold whole{kChannels, 3, kModes, {}};
  int explained = 0;
  for (whole.begin(given); whole.earlier(given);) ++explained;
  EXPECT_EQ(explained, 8);
  EXPECT_EQ(whole.fit().t0_ns(), 50'000'000);
  EXPECT_LT(whole.fit().samples(0), 1200.0);
  EXPECT_LT(std::abs(whole.fit().moved_poles().back() - chain.back()), 4 * whole.fit().u_pole(kModes - 1));
}

}  // namespace
}  // namespace dwell
