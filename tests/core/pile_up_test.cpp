// Readings cut off at an extreme show, and those of a motion that is not cut off never do.
#include "core/intake/pile_up.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace dwell {
namespace {

struct NoisyMotion {
  double noise = 0.0, step = 0.0;  // of an amplitude of 1
  double end = INFINITY;           // of the transducer
  double readings_a_period = 40.3;
  double third = 0.0;  // harmonic: 1/9 makes the crest flat
};

PileUp::Noise seen(const NoisyMotion& motion) {
  return {std::hypot(motion.noise, motion.step / std::sqrt(12.0)), motion.step};
}

// So many periods of a sine of amplitude 1 as the transducer shows it.
void play(PileUp& pile_up, const NoisyMotion& motion, double periods, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double phase = std::uniform_real_distribution<double>(0.0, 6.0)(random);
  double before = 0.0;
  for (int i = 0; i < periods * motion.readings_a_period; ++i) {
    const double at = 2 * M_PI * i / motion.readings_a_period + phase;
    double reading = std::sin(at) + motion.third * std::sin(3 * at) + motion.noise * normal(random);
    if (motion.step > 0) reading = motion.step * std::nearbyint(reading / motion.step);
    reading = std::min(reading, motion.end);
    pile_up.add(
        reading, before, [&] { return 4 / motion.readings_a_period; }, [&] { return seen(motion); });
    before = reading;
    if (std::floor((i + 1) / motion.readings_a_period) > std::floor(i / motion.readings_a_period))
      pile_up.next_period(seen(motion));
  }
}

std::int64_t found(const NoisyMotion& motion, double periods, std::uint64_t seed) {
  PileUp pile_up;
  play(pile_up, motion, periods, seed);
  EXPECT_EQ(pile_up.below(seen(motion)), 0) << seed;
  return pile_up.above(seen(motion));
}

TEST(PileUp, OfAMotionThatIsNotCutOffThereIsNone) {
  std::uint64_t seed = 0;
  for (const double noise : {0.0, 1e-4, 1e-3, 1.2e-3, 5e-3, 0.02})
    for (const double step : {0.0, 1e-6, 1e-4, 1e-3, 0.01})
      for (const double readings : {4.03, 7.07, 20.0, 40.3, 100.0, 403.0})
        for (const double periods : {3.0, 8.0, 100.0})
          EXPECT_EQ(found({noise, step, INFINITY, readings}, periods, ++seed), 0)
              << "noise " << noise << ", step " << step << ", readings " << readings << ", periods " << periods;
}

// Noise of three quarters of a step, at instants of its own and at a whole fraction of the period.
TEST(PileUp, OfAMotionThatIsNotCutOffThereIsNoneWhereNoiseIsHardlyMoreThanRounding) {
  for (const double readings : {20.0, 40.3, 100.0})
    for (const double periods : {3.0, 8.0, 30.0, 200.0})
      for (std::uint64_t seed = 1; seed <= 100; ++seed)
        EXPECT_EQ(found({0.76e-3, 1e-3, INFINITY, readings}, periods, seed), 0)
            << readings << " readings a period, " << periods << " periods, " << seed;
}

// Two readings of each crest are cut off, then six.
TEST(PileUp, ANoisyCrestCutOffShowsWithinAFewPeriods) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    EXPECT_GT(found({0.02, 0.0, 0.99}, 8.0, seed), 4);
    EXPECT_GT(found({0.02, 1e-5, 0.99}, 20.0, seed), 12);
    EXPECT_GT(found({0.02, 1e-3, 0.9}, 8.0, seed), 30);
    EXPECT_GT(found({0.8e-3, 1e-3, 0.9}, 8.0, seed), 30);
  }
}

// One reading a period at the crest, two next to it some steps below, and now and then one between.
TEST(PileUp, ACrestSampledAtAWholeFractionOfThePeriodIsNotCutOff) {
  for (const double readings : {20.0, 40.0, 100.0})
    for (std::uint64_t seed = 1; seed <= 50; ++seed)
      EXPECT_EQ(found({2e-4, 1e-3, INFINITY, readings}, 200.0, seed), 0) << readings << " readings a period, " << seed;
}

TEST(PileUp, ACrestThatHarmonicsHaveFlattenedIsNotCutOff) {
  std::uint64_t seed = 0;
  for (const double third : {0.01, 0.05, 1.0 / 9, 0.15})
    for (const double readings : {10.0, 12.0, 20.0, 40.0, 40.3, 100.0, 403.0})
      for (const double step : {1e-3, 4e-3, 0.02})
        for (const double noise : {0.0, 0.1, 0.5})
          for (int k = 0; k < 5; ++k)
            EXPECT_EQ(found({noise * step, step, INFINITY, readings, third}, 100.0, ++seed), 0)
                << "third " << third << ", readings " << readings << ", step " << step << ", noise " << noise;
}

// A held register that is not known to be one yet.
TEST(PileUp, OfAMotionThatIsNotCutOffThereIsNoneHoweverOftenEachReadingIsRepeated) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    PileUp pile_up;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    double before = 0.0;
    for (int i = 0; i < 400; ++i) {
      const double reading = std::sin(0.157 * i) + 0.02 * normal(random);
      for (int k = 0; k < 5; ++k, before = reading)
        pile_up.add(
            reading, before, [] { return 0.1; },
            [] {
              return PileUp::Noise{0.02, 0.0};
            });
    }
    EXPECT_EQ(pile_up.above({0.02, 0.0}), 0) << seed;
  }
}

TEST(PileUp, RepeatsOfALargestReadingAreNone) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    PileUp pile_up;
    const NoisyMotion motion{0.02};
    play(pile_up, motion, 8.0, seed);
    const double largest = pile_up.upper_end(seen(motion));
    for (int i = 0; i < 2; ++i)
      pile_up.add(
          largest, largest, [] { return 0.1; }, [&] { return seen(motion); });
    EXPECT_EQ(pile_up.above(seen(motion)), 0);
  }
}

// At 20 readings a period each number comes once a period, the one of the crest five times: a flattened crest might do
// so. A run of five that no crest explains tells.
TEST(PileUp, LongRunsAtTheExtremeAloneAreACrestCutOff) {
  const auto play_runs = [](PileUp& pile_up, int periods, int every_other, double end = 0.8) {
    double before = 0.0;
    for (int i = 0; i < 20 * periods; ++i) {
      const double reading = std::min(1e-3 * std::nearbyint(1e3 * std::sin(M_PI * i / 10)), end);
      pile_up.add(
          reading, before, [] { return 0.2; },
          [] {
            return PileUp::Noise{3e-4, 1e-3};
          });
      before = reading;
      if (i % 20 == 7 && end < 1) pile_up.stuck();                                       // the last reading at the end
      if (every_other > 0 && i % 20 == 1 && i / 20 % every_other == 0) pile_up.stuck();  // a repeated answer
    }
    return pile_up.above({3e-4, 1e-3});
  };
  PileUp few, enough, repeats;
  EXPECT_EQ(play_runs(few, 4, 0), 0);
  EXPECT_EQ(play_runs(enough, 5, 0), 25);
  EXPECT_EQ(play_runs(repeats, 5, 2), 0);

  // The same where the crests before were not cut off.
  PileUp later;
  const auto judge = [&later] {
    for (int period = 0; period < 16; ++period) later.next_period({3e-4, 1e-3});
  };
  for (int i = 0; i < 36; ++i) {
    EXPECT_EQ(play_runs(later, 16, 0, 2.0), 0);
    judge();
  }
  play_runs(later, 16, 0);
  judge();
  EXPECT_GT(later.above({3e-4, 1e-3}), 0);
  EXPECT_EQ(later.upper_end({3e-4, 1e-3}), 0.8);
}

// A converter's last digit: 98 % of the readings are one number.
TEST(PileUp, OfAChannelAtRestThereIsNone) {
  for (const double noise : {0.15, 0.3, 1.0})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      std::mt19937_64 random(seed);
      std::normal_distribution<double> normal;
      const PileUp::Noise known{std::hypot(noise, 1 / std::sqrt(12.0)), 1.0};
      PileUp pile_up;
      double before = 0.0;
      for (int i = 0; i < 20'000; ++i) {
        const double reading = std::nearbyint(0.2 + noise * normal(random));
        pile_up.add(
            reading, before, [] { return 0.1; }, [&] { return known; });
        before = reading;
        if (i % 100 == 0) pile_up.next_period(known);
      }
      EXPECT_EQ(pile_up.above(known), 0) << noise;
      EXPECT_EQ(pile_up.below(known), 0) << noise;
    }
}

// Relative loss of the fundamental of a sine cut off at one end, by its Fourier coefficient.
double lost_fundamental(double end) {
  double sum = 0.0;
  constexpr int kPhases = 100'000;
  for (int i = 0; i < kPhases; ++i) {
    const double sine = std::sin(2 * M_PI * i / kPhases);
    sum += 2.0 / kPhases * (sine - std::min(sine, end)) * sine;
  }
  return sum;
}

TEST(PileUp, ACrestCutOffFromSomeInstantOnIsFoundAndWhatItCostsIsKnown) {
  // With 40.3 readings a period there are 403 phases. Rounding without noise leaves few numbers beside an end of 0.95
  // then, as harmonics might, and it is not found; with 40.37 it is.
  for (const NoisyMotion& wide : {NoisyMotion{1e-3}, NoisyMotion{1e-4, 1e-3, INFINITY, 40.37}, NoisyMotion{0.01, 1e-6}})
    for (const double end : {0.2, 0.5, 0.8, 0.95}) {
      NoisyMotion narrow = wide;
      narrow.end = end;
      PileUp pile_up;
      play(pile_up, wide, 1000.0, 1);
      EXPECT_EQ(pile_up.above(seen(wide)), 0);
      play(pile_up, narrow, 512.0, 2);
      EXPECT_GT(pile_up.above(seen(narrow)), 0) << "cut off at " << end;
      EXPECT_EQ(pile_up.upper_end(seen(narrow)), end);
      EXPECT_EQ(pile_up.below(seen(narrow)), 0);
      // Half of the hold is clipped, so the fundamental is reduced by half as much as in a hold that is clipped
      // throughout. loss() counts clipped readings from the first stretch on that shows clipping.
      const double half = 0.5 * lost_fundamental(end);
      play(pile_up, narrow, 488.0, 3);
      EXPECT_LT(pile_up.loss(seen(narrow)), 1.05 * half) << end;  // noise puts 5 % more readings at the end
      EXPECT_GT(pile_up.loss(seen(narrow)), 0.7 * half) << end;   // at most 280 of the 1000 periods are missing
    }
}

// How many periods of a motion it takes until readings are found cut off.
double periods_to_find(PileUp& pile_up, const NoisyMotion& narrow, std::uint64_t seed) {
  double periods = 0.0;
  while (pile_up.above(seen(narrow)) == 0 && periods < 10'000) {
    play(pile_up, narrow, 16.0, ++seed);
    periods += 16;
  }
  return periods;
}

// Whatever the rate: a stretch of a fixed number of readings lasts for minutes where a period has few of them.
TEST(PileUp, ACrestCutOffFromSomeInstantOnIsFoundWithinEightTimesWhatItTakesFromTheBeginning) {
  std::uint64_t seed = 0;
  for (const double readings : {5.03, 10.3, 40.37, 200.3})
    for (const double noise : {1e-3, 0.01})
      for (const double end : {0.3, 0.8, 0.95})
        for (const double before : {100.0, 1000.0, 1030.0, 4100.0, 5000.0, 8961.0}) {
          const NoisyMotion wide{noise, 1e-3, INFINITY, readings}, narrow{noise, 1e-3, end, readings};
          PileUp fresh, later;
          const double alone = periods_to_find(fresh, narrow, 1000 * ++seed);
          ASSERT_LT(alone, 1000);
          play(later, wide, before, seed);
          ASSERT_EQ(later.above(seen(wide)), 0);
          EXPECT_LE(periods_to_find(later, narrow, 1000 * seed), 8 * alone)
              << readings << " readings a period, noise " << noise << ", end " << end << ", after " << before;
        }
}

// A slowly swinging amplitude is no clipping: its lower crests are no ends.
TEST(PileUp, OfAMotionWhoseAmplitudeSwingsThereIsNone) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    std::mt19937_64 random(seed);
    const auto between = [&random](double a, double b) {
      return std::exp(std::uniform_real_distribution(std::log(a), std::log(b))(random));
    };
    const double readings = between(4.0, 200.0), depth = between(1e-4, 0.1), swing = between(5.0, 3000.0);
    const double step = std::array{0.0, 1e-4, 1e-3, 0.01}[seed % 4];
    const double noise = seed % 3 == 0 ? step * between(0.1, 1.5) : between(1e-5, 0.03);
    std::normal_distribution<double> normal;
    const PileUp::Noise known{std::hypot(noise, step / std::sqrt(12.0)), step};
    PileUp pile_up;
    double before = 0.0;
    for (int i = 0; i < 50'000; ++i) {
      const double at = 2 * M_PI * i / readings;
      double reading = (1 + depth * std::sin(at / swing)) * std::sin(at) + noise * normal(random);
      if (step > 0) reading = step * std::nearbyint(reading / step);
      pile_up.add(
          reading, before, [&] { return 4 / readings; }, [&] { return known; });
      before = reading;
      if (std::floor((i + 1) / readings) > std::floor(i / readings)) pile_up.next_period(known);
    }
    EXPECT_EQ(pile_up.above(known) + pile_up.below(known), 0)
        << readings << " readings a period, noise " << noise << ", step " << step << ", depth " << depth << ", swing "
        << swing;
  }
}

// A day at 1 Hz: chance gets no more occasions, however long the hold.
TEST(PileUp, OfALongHoldThatIsNotCutOffThereIsNone) {
  std::uint64_t seed = 0;
  for (const double noise : {0.0, 1e-3, 0.02})
    for (const double step : {0.0, 1e-3, 0.01}) EXPECT_EQ(found({noise, step, INFINITY, 20.3}, 86'400, ++seed), 0);
}

TEST(PileUp, WhatWasCutOffStaysSoThoughTheRangeIsWidened) {
  for (const NoisyMotion& wide : {NoisyMotion{1e-3}, NoisyMotion{1e-4, 1e-3}, NoisyMotion{0.01, 1e-6}}) {
    NoisyMotion narrow = wide;
    narrow.end = 0.8;
    PileUp pile_up;
    play(pile_up, narrow, 30.0, 1);
    const std::int64_t cut_off = pile_up.above(seen(narrow));
    EXPECT_GT(cut_off, 0);
    const double loss = pile_up.loss(seen(narrow));
    play(pile_up, wide, 30.0, 2);
    EXPECT_NEAR(pile_up.loss(seen(wide)), 0.5 * loss, 0.03 * loss) << "the mean of both halves";
    play(pile_up, wide, 70.0, 2);
    EXPECT_EQ(pile_up.above(seen(wide)), cut_off);
    EXPECT_EQ(pile_up.upper_end(seen(wide)), 0.8);
    EXPECT_EQ(pile_up.below(seen(wide)), 0);
    pile_up.restart(seen(wide));
    play(pile_up, wide, 100.0, 3);
    EXPECT_EQ(pile_up.above(seen(wide)), 0);
  }
}

TEST(PileUp, TheNewestEndIsTold) {
  const NoisyMotion narrow{1e-3, 0.0, 0.5}, wider{1e-3, 0.0, 0.8};
  PileUp pile_up;
  play(pile_up, narrow, 100.0, 1);
  EXPECT_EQ(pile_up.upper_end(seen(narrow)), 0.5);
  play(pile_up, wider, 100.0, 2);
  EXPECT_EQ(pile_up.upper_end(seen(wider)), 0.8);
}

TEST(PileUp, AnEndOnceFoundNeedsNoProofLater) {
  const NoisyMotion motion{1e-4, 1e-3, 0.9};
  PileUp pile_up;
  play(pile_up, motion, 60.0, 1);
  ASSERT_GT(pile_up.above(seen(motion)), 0);
  PileUp other;
  play(other, motion, 3.0, 2);
  EXPECT_EQ(other.above(seen(motion)), 0);
  pile_up.restart(seen(motion));
  EXPECT_EQ(pile_up.above(seen(motion)), 0);
  play(pile_up, motion, 3.0, 2);
  EXPECT_GT(pile_up.above(seen(motion)), 10);
}

}  // namespace
}  // namespace dwell
