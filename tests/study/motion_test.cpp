// The study's own simulation against the exact one of core, which it shares no line with.
#include "tests/study/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/model/driven_chain.hpp"
#include "tests/study/case.hpp"
#include "tests/study/draw_parts.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

double exact(const Sensor& sensor, const ChainMotion& motion) {
  if (sensor.measures == Quantity::force) return motion.ground_force;
  const std::vector<double>& of = sensor.measures == Quantity::velocity       ? motion.velocity
                                  : sensor.measures == Quantity::acceleration ? motion.acceleration
                                                                              : motion.y;
  return of[static_cast<std::size_t>(sensor.at)] -
         (sensor.relative_to ? of[static_cast<std::size_t>(*sensor.relative_to)] : 0.0);
}

TEST(StudyMotion, ReadsWhatTheExactSimulationReadsFromRestAndAfterAChange) {
  for (int index = 0; index < 20; ++index) {
    Draws draws(static_cast<std::uint64_t>(index));
    Case about;
    about.frequency_hz = 5.0;
    draw_chain(draws, about);
    draw_channels(draws, about);
    Motion motion(about.chain, about.sensors);
    motion.drive(0.0, {5.0, {0.002, std::polar(0.0001, 0.7)}});
    DrivenChain chain(about.chain, Drive{5.0, 0.002, 0.0, 0.0, {{2, 0.0001, 0.7}}}, DrivenChain::Start::rest);
    const double change_s = 2.2;  // eleven periods: both drives have the same phase there
    for (const double from_s : {0.0, change_s}) {
      if (from_s > 0) {
        motion.drive(change_s, {4.0, {0.003}});
        chain.set_drive(change_s, Drive{4.0, 0.003});
      }
      for (int i = 0; i < 200; ++i) {
        const double t_s = from_s + 0.0107 * (i + 1);
        const ChainMotion& truth = chain.at(t_s);
        for (std::size_t c = 0; c < about.sensors.size(); ++c) {
          const double scale = std::abs(motion.phasor(static_cast<int>(c), 1));
          const double expected = exact(about.sensors[c], truth);
          ASSERT_NEAR(motion.reading(static_cast<int>(c), t_s), expected,
                      1e-7 * (scale + std::abs(expected) + motion.envelope(static_cast<int>(c), from_s)))
              << "rig " << index << ", channel " << c << " at " << t_s << " s";
        }
      }
    }
  }
}

TEST(StudyMotion, TheTransientIsWhatThePhasorsLeave) {
  const Case about = draw(Population::white, 1, 3);
  for (int c = 0; c < about.channels(); ++c)
    for (int i = 0; i < 50; ++i) {
      const double t_s = about.motion->start_s() + 0.013 * i;
      double steady = 0.0;
      for (int h = 1; h <= 3; ++h)
        steady += (about.motion->phasor(c, h) *
                   std::polar(1.0, h * 2 * std::numbers::pi * about.frequency_hz * (t_s - about.motion->start_s())))
                      .imag();
      EXPECT_NEAR(
          about.motion->reading(c, t_s) - steady, about.motion->transient(c, t_s),
          1e-9 * std::abs(about.motion->phasor(c, 1)) + 1e-3 * about.lines[static_cast<std::size_t>(c)].noise());
    }
}

TEST(StudyMotion, NothingIsAboveTheLimitAfterTheLastInstantThatIs) {
  for (int index = 0; index < 30; ++index) {
    const Case about = draw(Population::white, 2, index);
    for (int c = 1; c < about.channels(); ++c) {
      const double limit = about.threshold(c), last_s = about.motion->last_above(c, limit);
      EXPECT_LE(about.motion->largest_from(c, last_s + 0.1 * about.period_s()), 1.05 * limit);
    }
  }
}

TEST(StudyRecording, IsOrderedAndTheSameWheneverItIsPlayed) {
  const Case about = draw(Population::type_b, 1, 5), again = draw(Population::type_b, 1, 5);
  Player one(about), other(again);
  std::int64_t before = INT64_MIN;
  for (int i = 0; i < 5000; ++i) {
    const Record a = one.next(), b = other.next();
    ASSERT_GE(a.t_ns, before);
    ASSERT_EQ(a.t_ns, b.t_ns);
    ASSERT_EQ(a.value, b.value);
    before = a.t_ns;
  }
}

}  // namespace
}  // namespace dwell::study
