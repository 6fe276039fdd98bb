#include "core/fit/moving_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/dwell/errors_in_motion.hpp"

namespace dwell {
namespace {

constexpr double kShaken_rad_s = kTwoPi * 4.0, kStroke_m = 5e-3, kNoise_m = 5e-6, kPhase_rad = 0.7;
constexpr int kReadings = 4000;

double motion(double t_s) {
  return kStroke_m * std::sin(kShaken_rad_s * t_s + kPhase_rad) + 2e-4 * std::sin(3 * kShaken_rad_s * t_s);
}

// A channel of a steady motion, and the fit of its first three harmonics.
class SteadyChannel {
 public:
  // value: what is read at an instant, s; noise is added.
  SteadyChannel(const std::function<double(double)>& value, std::uint64_t seed, double read_hz = 200,
                double noise_m = kNoise_m)
      : rng_(seed) {
    std::normal_distribution<double> normal;
    for (int i = 0; i < kReadings; ++i) {
      const double t_s = i / read_hz;
      readings_.push_back({.t_ns = to_ns(t_s), .value = value(t_s) + noise_m * normal(rng_)});
    }
    context_.omega = kShaken_rad_s;
    context_.fit.usable = true;
    context_.fit.mean = 0.0;
    context_.fit.X[0] = std::polar(kStroke_m, kPhase_rad);
    context_.fit.X[2] = 2e-4;
  }
  MovingContext& context() { return context_; }
  MovingErrors errors() { return moving_errors(readings_, context_); }
  MovingChannel seen() {
    const MovingErrors found = errors();
    return {readings_, kStroke_m, found};
  }

 private:
  std::mt19937_64 rng_;
  std::vector<MovingReading> readings_;
  MovingContext context_;
};

struct Uniform {
  std::mt19937_64 rng;
  std::uniform_real_distribution<double> draw{0, 1};
  double operator()() { return draw(rng); }
};

TEST(MovingErrors, NoiseIsNone) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const MovingErrors found = SteadyChannel(motion, seed).errors();
    EXPECT_EQ(found.instants_s, 0.0) << seed;
    EXPECT_EQ(found.part, 0.0) << seed;
  }
}

TEST(MovingErrors, OfInstantsAreFoundWithTheirSize) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Uniform uniform{std::mt19937_64(100 + seed)};
    constexpr double kLatest_s = 2e-4;
    const MovingErrors found =
        SteadyChannel([&](double t_s) { return motion(t_s - kLatest_s * uniform()); }, seed).errors();
    EXPECT_NEAR(found.instants_s * found.instants_s, kLatest_s * kLatest_s / 12, 4 * found.instants_u2) << seed;
    EXPECT_LT(found.instants_u2, 0.2 * kLatest_s * kLatest_s / 12) << seed;
    EXPECT_EQ(found.part, 0.0) << seed;
  }
}

TEST(MovingErrors, OfReadingsOnAnotherScaleAreFoundWithTheirSize) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Uniform uniform{std::mt19937_64(100 + seed)};
    const MovingErrors found =
        SteadyChannel([&](double t_s) { return (uniform() < 0.25 ? 0.1 : 1.0) * motion(t_s); }, seed).errors();
    EXPECT_NEAR(found.part, 0.9 * std::sqrt(0.25 * 0.75), 0.1 * 0.9 * std::sqrt(0.25 * 0.75)) << seed;
    EXPECT_EQ(found.instants_s, 0.0) << seed;
  }
}

TEST(MovingErrors, WhatIsSmoothOrRepeatsWithTheMotionIsNone) {
  struct Case {
    const char* what;
    std::function<double(double)> value;
  };
  const auto hunting = [](double hz, double part) {
    return [=](double t_s) { return motion(t_s) * (1 + part * std::sin(kTwoPi * hz * t_s)); };
  };
  const std::vector<Case> cases = {
      {"a drive that hunts slowly", hunting(0.3, 0.01)},
      {"a drive that hunts fast", hunting(1.3, 0.003)},
      {"harmonics that are not fitted",
       [](double t_s) {
         return motion(t_s) + 1e-4 * std::sin(5 * kShaken_rad_s * t_s) + 5e-5 * std::sin(7 * kShaken_rad_s * t_s);
       }},
      {"hum", [](double t_s) { return motion(t_s) + 5e-5 * std::sin(kTwoPi * 49.7 * t_s); }},
      {"a transient", [](double t_s) { return motion(t_s) + 1e-4 * std::exp(-t_s) * std::sin(kTwoPi * 4.1 * t_s); }}};
  for (const Case& one : cases)
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const MovingErrors found = SteadyChannel(one.value, seed).errors();
      EXPECT_EQ(found.instants_s, 0.0) << one.what << ", " << seed;
      EXPECT_EQ(found.part, 0.0) << one.what << ", " << seed;
    }
}

TEST(MovingErrors, RoundingIsNone) {
  for (const double step_m : {1e-5, 5e-5, 2e-4}) {
    SteadyChannel channel([&](double t_s) { return step_m * std::round(motion(t_s) / step_m); }, 1, 203.0, 0.0);
    channel.context().rounding = step_m;
    EXPECT_EQ(channel.errors().instants_s, 0.0) << step_m;
    EXPECT_EQ(channel.errors().part, 0.0) << step_m;
  }
}

TEST(MovingErrors, ThatTheBudgetHasAreNone) {
  Uniform uniform{std::mt19937_64(5)};
  SteadyChannel channel([&](double t_s) { return motion(t_s - 2e-4 * uniform()); }, 1);
  EXPECT_GT(channel.errors().instants_s, 0.0);
  channel.context().known_instants_s = 2e-4 / std::sqrt(12.0);
  EXPECT_EQ(channel.errors().instants_s, 0.0);
}

TEST(MovingErrors, AreNotLookedForInFewReadingsOrFewOfAPeriod) {
  Uniform uniform{std::mt19937_64(5)};
  const auto late = [&](double t_s) { return motion(t_s - 2e-3 * uniform()); };
  EXPECT_GT(SteadyChannel(late, 1, 60).errors().instants_s, 0.0);
  EXPECT_EQ(SteadyChannel(late, 1, 40).errors().instants_s, 0.0) << "ten in a period";
  std::vector<MovingReading> few(100);
  for (std::size_t i = 0; i < few.size(); ++i) few[i].t_ns = to_ns(static_cast<double>(i) / 200);
  EXPECT_EQ(moving_errors(few, SteadyChannel(late, 1).context()).instants_s, 0.0);
  EXPECT_EQ(moving_errors({}, SteadyChannel(late, 1).context()).instants_s, 0.0);
}

TEST(MovingErrors, OfOneStampForSeveralChannelsAreShared) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Uniform stamps{std::mt19937_64(7)}, same{std::mt19937_64(7)}, others{std::mt19937_64(500 + seed)};
    SteadyChannel one([&](double t_s) { return motion(t_s - 2e-4 * stamps()); }, seed),
        other([&](double t_s) { return motion(t_s - 2e-4 * same()); }, 1000 + seed),
        apart([&](double t_s) { return motion(t_s - 2e-4 * others()); }, 2000 + seed), sound(motion, 3000 + seed);
    EXPECT_TRUE(share_instants(one.seen(), other.seen(), kShaken_rad_s)) << seed;
    EXPECT_FALSE(share_instants(one.seen(), apart.seen(), kShaken_rad_s)) << seed;
    EXPECT_FALSE(share_instants(one.seen(), sound.seen(), kShaken_rad_s)) << seed;
  }
}

TEST(ErrorsInMotion, AreLookedForAfterTwelvePeriodsAndEachTimeTheDataHaveDoubled) {
  ErrorsInMotion errors(1);
  errors.begin(to_ns(10.0));
  const SampleHistory nothing(16);
  const auto context = [](int, std::int64_t) { return MovingContext{}; };
  EXPECT_FALSE(errors.due(to_ns(12.9), 0.25));
  EXPECT_TRUE(errors.due(to_ns(13.0), 0.25));
  errors.look(nothing, to_ns(13.0), context);
  EXPECT_FALSE(errors.due(to_ns(15.9), 0.25));
  EXPECT_TRUE(errors.due(to_ns(16.0), 0.25));
  errors.look(nothing, to_ns(16.0), context);
  EXPECT_FALSE(errors.due(to_ns(21.9), 0.25));
  EXPECT_TRUE(errors.due(to_ns(22.0), 0.25));
}

// Puts `seconds` of channels into a history, each with the value of its function.
void fill(SampleHistory& history, const std::vector<std::function<double(double)>>& channels, double seconds) {
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < static_cast<int>(200 * seconds); ++i)
    for (std::size_t c = 0; c < channels.size(); ++c)
      history.push(to_ns(i / 200.0), static_cast<int>(c), channels[c](i / 200.0) + kNoise_m * normal(rng));
}

TEST(ErrorsInMotion, TellWhichChannelsShareThemAndForgetThemWithTheNextDwell) {
  Uniform uniform{std::mt19937_64(3)};
  double late_s = 0.0;
  const auto stamped = [&](double t_s) { return motion(t_s - late_s); };
  const auto first = [&](double t_s) {
    late_s = 2e-4 * uniform();
    return stamped(t_s);
  };
  const auto alone = [&](double t_s) { return motion(t_s - 3e-4 * uniform()); };
  SampleHistory history(1 << 15);
  fill(history, {first, motion, stamped, alone}, 20);
  ErrorsInMotion errors(4);
  errors.begin(0);
  SteadyChannel channel(motion, 1);
  errors.look(history, to_ns(20.0), [&](int, std::int64_t about_ns) {
    MovingContext of = channel.context();
    for (int h = 1; h <= 3; ++h)
      of.fit.X[static_cast<std::size_t>(h - 1)] *= std::polar(1.0, h * kShaken_rad_s * to_s(about_ns));
    of.t_ref_ns = about_ns;
    return of;
  });
  EXPECT_NEAR(errors.shared_s(0), 2e-4 / std::sqrt(12.0), 6e-6);
  EXPECT_EQ(errors.shared_s(0), errors.shared_s(2)) << "the same number, so that it cancels";
  EXPECT_EQ(errors.with(2), 0);
  EXPECT_EQ(errors.own_s(0), 0.0);
  EXPECT_EQ(errors.own_s(2), 0.0);
  EXPECT_EQ(errors.own_s(1), 0.0);
  EXPECT_EQ(errors.with(1), -1);
  EXPECT_NEAR(errors.own_s(3), 3e-4 / std::sqrt(12.0), 9e-6);
  EXPECT_EQ(errors.with(3), -1);
  EXPECT_EQ(errors.part(3), 0.0);
  errors.begin(to_ns(20.0));
  EXPECT_EQ(errors.own_s(3), 0.0);
  EXPECT_EQ(errors.with(2), -1);
}

}  // namespace
}  // namespace dwell
