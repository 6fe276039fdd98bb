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

// The same without its harmonic, which makes the slope 12 % steeper at the zero crossings.
double sine(double t_s) { return kStroke_m * std::sin(kShaken_rad_s * t_s + kPhase_rad); }

// A channel of a steady motion, and the fit of its first three harmonics.
class SteadyChannel {
 public:
  // value: what is read at an instant, s; noise is added. uneven: instants scatter by this part of an interval, known.
  SteadyChannel(const std::function<double(double)>& value, std::uint64_t seed, double read_hz = 200,
                double noise_m = kNoise_m, double uneven = 0.0)
      : rng_(seed) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> off(-0.5, 0.5);
    for (int i = 0; i < kReadings; ++i) {
      const std::int64_t t_ns = to_ns((i + uneven * off(rng_)) / read_hz);
      readings_.push_back({.t_ns = t_ns, .value = value(to_s(t_ns)) + noise_m * normal(rng_)});
    }
    context_.omega = kShaken_rad_s;
    context_.interval_s = 1 / read_hz;
    context_.fit.usable = true;
    context_.fit.mean = 0.0;
    context_.fit.X[0] = std::polar(kStroke_m, kPhase_rad);
    context_.fit.X[2] = 2e-4;
  }
  MovingContext& context() { return context_; }
  MovingErrors errors() { return moving_errors(readings_, context_); }
  MovingChannel seen() {
    const MovingErrors found = errors();
    return {.readings = readings_, .amplitude = kStroke_m, .errors = found};
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

TEST(MovingErrors, NoiseAloneShowsNone) {
  for (const double read_hz : {65.0, 83.0, 200.0, 811.0})
    for (const double uneven : {0.0, 0.4})
      for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        const MovingErrors found = SteadyChannel(motion, seed, read_hz, kNoise_m, uneven).errors();
        EXPECT_EQ(found.instants_s, 0.0) << read_hz << " Hz, " << seed;
        EXPECT_EQ(found.part, 0.0) << read_hz << " Hz, " << seed;
      }
}

// The sizes are right at any rate, and where instants are uneven. The stated uncertainty is that of 100 draws.
TEST(MovingErrors, OfInstantsAreFoundWithTheirSize) {
  constexpr double kLatest_s = 3e-4, kSquare_s2 = kLatest_s * kLatest_s / 12;
  for (const double read_hz : {65.0, 83.0, 200.0})
    for (const double uneven : {0.0, 0.4}) {
      double squares = 0.0, sum = 0.0;
      for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        Uniform uniform{std::mt19937_64(7919 * seed)};
        const MovingErrors found = SteadyChannel([&](double t_s) { return sine(t_s - kLatest_s * uniform()); }, seed,
                                                 read_hz, kNoise_m, uneven)
                                       .errors();
        const double off = (found.instants_s * found.instants_s - kSquare_s2) / found.instants_u2;
        EXPECT_EQ(found.part, 0.0) << read_hz << " Hz, " << seed;
        squares += off * off / 100;
        sum += found.instants_s * found.instants_s / 100;
      }
      EXPECT_NEAR(sum, kSquare_s2, 0.05 * kSquare_s2) << read_hz << " Hz, uneven " << uneven;
      EXPECT_NEAR(std::sqrt(squares), 1.0, 0.3) << read_hz << " Hz, uneven " << uneven;
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

TEST(MovingErrors, WhatIsSmoothOrRepeatsWithTheMotionShowsNone) {
  struct Case {
    const char* what;
    std::function<double(double)> value;
  };
  const auto hunting = [](double hz, double part, double phase_rad) {
    return [=](double t_s) {
      const double swing = std::sin(kTwoPi * hz * t_s);
      return (1 + part * swing) * motion(t_s + phase_rad * swing / kShaken_rad_s);
    };
  };
  const std::vector<Case> cases = {
      {"an amplitude that hunts slowly", hunting(0.3, 0.02, 0.0)},
      {"an amplitude that hunts fast", hunting(1.3, 0.005, 0.0)},
      {"a phase that hunts fast", hunting(1.3, 0.0, 0.005)},
      {"harmonics that are not fitted",
       [](double t_s) {
         return motion(t_s) + 5e-5 * std::sin(5 * kShaken_rad_s * t_s) + 3e-5 * std::sin(7 * kShaken_rad_s * t_s + 1);
       }},
      {"friction",
       [](double t_s) {
         return motion(t_s) + 0.02 * kStroke_m * std::copysign(1.0, std::cos(kShaken_rad_s * t_s + kPhase_rad));
       }},
      {"clipping", [](double t_s) { return std::clamp(motion(t_s), -0.9 * kStroke_m, 0.7 * kStroke_m); }},
      {"hum", [](double t_s) { return motion(t_s) + 5e-5 * std::sin(kTwoPi * 49.7 * t_s); }},
      {"a transient", [](double t_s) { return motion(t_s) + 1e-4 * std::exp(-t_s) * std::sin(kTwoPi * 4.1 * t_s); }}};
  for (const Case& one : cases)
    for (const double read_hz : {66.7, 80.3, 200.0})
      for (const double uneven : {0.0, 0.4})
        for (std::uint64_t seed = 1; seed <= 10; ++seed) {
          const MovingErrors found = SteadyChannel(one.value, seed, read_hz, 1e-6, uneven).errors();
          EXPECT_EQ(found.instants_s, 0.0) << one.what << " at " << read_hz << " Hz, " << seed;
          EXPECT_EQ(found.part, 0.0) << one.what << " at " << read_hz << " Hz, " << seed;
        }
}

TEST(MovingErrors, RoundingShowsNone) {
  for (const double step_m : {1e-5, 5e-5, 2e-4})
    for (const double read_hz : {71.0, 200.0, 203.0}) {
      SteadyChannel channel([&](double t_s) { return step_m * std::round(motion(t_s) / step_m); }, 1, read_hz, 0.0);
      channel.context().rounding = step_m;
      EXPECT_EQ(channel.errors().instants_s, 0.0) << step_m << " m, " << read_hz << " Hz";
      EXPECT_EQ(channel.errors().part, 0.0) << step_m << " m, " << read_hz << " Hz";
    }
}

TEST(MovingErrors, AreNotLookedForInFewReadingsOrFewOfAPeriod) {
  Uniform uniform{std::mt19937_64(5)};
  const auto late = [&](double t_s) { return motion(t_s - 2e-3 * uniform()); };
  EXPECT_GT(SteadyChannel(late, 1, 66).errors().instants_s, 0.0);
  EXPECT_EQ(SteadyChannel(late, 1, 60).errors().instants_s, 0.0) << "fifteen in a period";
  std::vector<MovingReading> few(100);
  for (std::size_t i = 0; i < few.size(); ++i) few[i].t_ns = to_ns(static_cast<double>(i) / 200);
  EXPECT_EQ(moving_errors(few, SteadyChannel(late, 1).context()).instants_s, 0.0);
  EXPECT_EQ(moving_errors({}, SteadyChannel(late, 1).context()).instants_s, 0.0);
}

TEST(MovingErrors, OfOneStampForSeveralChannelsAreShared) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Uniform stamps{std::mt19937_64(7)}, same{std::mt19937_64(7)}, again{std::mt19937_64(7)},
        others{std::mt19937_64(500 + seed)}, more{std::mt19937_64(600 + seed)};
    SteadyChannel one([&](double t_s) { return motion(t_s - 3e-4 * stamps()); }, seed),
        other([&](double t_s) { return motion(t_s - 3e-4 * same()); }, 1000 + seed),
        late([&](double t_s) { return motion(t_s - 3e-4 * again() - 4e-4 * more()); }, 4000 + seed),
        apart([&](double t_s) { return motion(t_s - 3e-4 * others()); }, 2000 + seed), sound(motion, 3000 + seed);
    EXPECT_TRUE(share_instants(one.seen(), other.seen(), kShaken_rad_s)) << seed;
    EXPECT_FALSE(share_instants(one.seen(), late.seen(), kShaken_rad_s)) << "it has errors of its own beside, " << seed;
    EXPECT_FALSE(share_instants(one.seen(), apart.seen(), kShaken_rad_s)) << seed;
    EXPECT_FALSE(share_instants(one.seen(), sound.seen(), kShaken_rad_s)) << seed;
  }
}

// Channels of one history, each read at its own rate.
class Rack {
 public:
  struct Line {
    std::function<double(double)> value;
    double read_hz = 200;
    double known_s = 0.0;
  };
  explicit Rack(std::vector<Line> lines)
      : lines_(std::move(lines)), history_(1 << 17), errors(static_cast<int>(lines_.size())) {
    errors.begin(0);
  }
  // Reads all lines until then, and looks once.
  void look(double until_s) {
    while (true) {
      std::size_t next = 0;
      for (std::size_t c = 1; c < lines_.size(); ++c)
        if (due_s(c) < due_s(next)) next = c;
      if (!(due_s(next) < until_s)) break;
      const double t_s = due_s(next);
      history_.push(to_ns(t_s), static_cast<int>(next), lines_[next].value(t_s) + kNoise_m * normal_(rng_));
      ++read_[next];
    }
    errors.look(history_, 0, to_ns(until_s), *this);
  }
  [[nodiscard]] int every(int c) const { return ErrorsInMotion::every(1 / line(c).read_hz, 0.25); }
  [[nodiscard]] static double transient(int, std::int64_t) { return 0.0; }
  [[nodiscard]] ErrorsInMotion::About about(int c, std::int64_t about_ns) const {
    MovingContext of = SteadyChannel(motion, 1).context();
    for (int h = 1; h <= 3; ++h)
      of.fit.X[static_cast<std::size_t>(h - 1)] *= std::polar(1.0, h * kShaken_rad_s * to_s(about_ns));
    of.t_ref_ns = about_ns;
    of.interval_s = every(c) / line(c).read_hz;
    return {of, line(c).known_s};
  }

 private:
  [[nodiscard]] const Line& line(int c) const { return lines_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] double due_s(std::size_t c) const { return static_cast<double>(read_[c]) / lines_[c].read_hz; }

  std::vector<Line> lines_;
  std::vector<long> read_ = std::vector<long>(lines_.size());
  SampleHistory history_;
  std::mt19937_64 rng_{1};
  std::normal_distribution<double> normal_;

 public:
  ErrorsInMotion errors;
};

// A function that is late by a random time; those with the same seed are late together, if read in turn.
std::function<double(double)> late(double latest_s, std::uint64_t seed) {
  return [latest_s, uniform = Uniform{std::mt19937_64(seed)}](double t_s) mutable {
    return motion(t_s - latest_s * uniform());
  };
}

TEST(ErrorsInMotion, AreLookedForAfterTwelvePeriodsAndEachTimeTheDataHaveDoubled) {
  Rack rack({{motion}});
  ErrorsInMotion& errors = rack.errors;
  errors.begin(to_ns(10.0));
  EXPECT_FALSE(errors.due(to_ns(12.9), 0.25));
  EXPECT_TRUE(errors.due(to_ns(13.0), 0.25));
  rack.look(13.0);
  EXPECT_FALSE(errors.due(to_ns(15.9), 0.25));
  EXPECT_TRUE(errors.due(to_ns(16.0), 0.25));
  rack.look(16.0);
  EXPECT_FALSE(errors.due(to_ns(21.9), 0.25));
  EXPECT_TRUE(errors.due(to_ns(22.0), 0.25));
}

TEST(ErrorsInMotion, TellWhichChannelsShareThemAndForgetThemWithTheNextDwell) {
  Rack rack({{late(3e-4, 3)}, {motion}, {late(3e-4, 3)}, {late(4e-4, 8)}});
  rack.look(20.0);
  const ErrorsInMotion& errors = rack.errors;
  EXPECT_NEAR(errors.shared_s(0), 3e-4 / std::sqrt(12.0), 9e-6);
  EXPECT_EQ(errors.shared_s(0), errors.shared_s(2)) << "the same number, so that it cancels";
  EXPECT_EQ(errors.with(2), 0);
  EXPECT_EQ(errors.own_s(0), 0.0);
  EXPECT_EQ(errors.own_s(2), 0.0);
  EXPECT_EQ(errors.own_s(1), 0.0);
  EXPECT_EQ(errors.with(1), -1);
  EXPECT_NEAR(errors.own_s(3), 4e-4 / std::sqrt(12.0), 12e-6);
  EXPECT_EQ(errors.with(3), -1);
  EXPECT_EQ(errors.part(3), 0.0);
  rack.errors.begin(to_ns(20.0));
  EXPECT_EQ(errors.own_s(3), 0.0);
  EXPECT_EQ(errors.with(2), -1);
}

TEST(ErrorsInMotion, AreFoundInSlowChannelsBesideFastOnes) {
  Rack rack({{late(3e-4, 1), 5000}, {late(2e-3, 2), 70}});
  rack.look(20.0);
  EXPECT_NEAR(rack.errors.own_s(0), 3e-4 / std::sqrt(12.0), 15e-6);
  EXPECT_NEAR(rack.errors.own_s(1), 2e-3 / std::sqrt(12.0), 1e-4);
}

TEST(ErrorsInMotion, WhichTheBudgetHasAreNoneAndHideNoneOfOneChannelAlone) {
  constexpr double kKnown_s = 3e-4 / 3.4641016151377544;
  Rack known({{late(3e-4, 3), 200, kKnown_s}, {late(3e-4, 3), 200, kKnown_s}});
  known.look(20.0);
  EXPECT_LT(known.errors.shared_s(0), 0.3 * kKnown_s);
  EXPECT_EQ(known.errors.own_s(0), 0.0);
  const auto twice = [first = late(3e-4, 3), uniform = Uniform{std::mt19937_64(9)}](double t_s) mutable {
    return first(t_s - 5e-4 * uniform());
  };
  Rack beside({{late(3e-4, 3), 200, kKnown_s}, {twice, 200, kKnown_s}});
  beside.look(20.0);
  EXPECT_NEAR(beside.errors.own_s(1), 5e-4 / std::sqrt(12.0), 2e-5);
}

TEST(ErrorsInMotion, OfAGroupKeepOneNumberWhenTheGroupGrows) {
  // The third channel begins to scatter with the others' stamps at 20 s; the first is then silent.
  auto third = [scatter = late(4e-4, 3)](double t_s) mutable {
    const double scattered = scatter(t_s);
    return t_s < 20 ? motion(t_s) : scattered;
  };
  Rack rack({{late(3e-4, 3)}, {late(3e-4, 3)}, {third}});
  rack.look(20.0);
  EXPECT_EQ(rack.errors.with(1), 0);
  EXPECT_EQ(rack.errors.with(2), -1);
  const double before = rack.errors.shared_s(1);
  rack.look(45.0);
  EXPECT_GE(rack.errors.shared_s(1), before);
  EXPECT_EQ(rack.errors.shared_s(0), rack.errors.shared_s(1));
  EXPECT_GT(rack.errors.own_s(2) + rack.errors.shared_s(2), 0.5 * 4e-4 / std::sqrt(12.0));
}

}  // namespace
}  // namespace dwell
