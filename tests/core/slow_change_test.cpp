// What changes slowly is followed: the shaker's frequency, the rig as it warms up. The motion is quasi-static: at every
// instant the steady response of the chain as it then is, at the frequency as it then is.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {
namespace {

struct SlowRig {
  Chain chain;
  Rig rig;
  double frequency_hz = 5.0, frequency_drift = 0.0;  // relative, per s
  double stiffness_drift = 0.0;                      // relative, per s, of the first element
  double noise = 1e-3;

  [[nodiscard]] Chain at(double t_s) const {
    Chain now = chain;
    now.stiffness[0] *= 1 + stiffness_drift * t_s;
    return now;
  }
  [[nodiscard]] double frequency_at(double t_s) const { return frequency_hz * (1 + frequency_drift * t_s); }

  // Streams the motion; returns how many dwells were completed on the way.
  int run(Pipeline& pipeline, double seconds) const {
    std::mt19937_64 rng(5);
    std::normal_distribution<double> normal;
    const double rate_hz = 200;
    int completed = 0;
    SteadyResponse response;
    for (int i = 0; i < seconds * rate_hz; ++i) {
      const double t_s = i / rate_hz;
      if (i % 20 == 0) response = steady_response(at(t_s), 2 * M_PI * frequency_at(t_s), 0.002);
      const double theta = 2 * M_PI * frequency_hz * (t_s + 0.5 * frequency_drift * t_s * t_s);
      for (std::size_t c = 0; c < rig.channels.size(); ++c) {
        const Phasor X = c < response.Y.size() ? response.Y[c] : response.F;
        Record record;
        record.t_ns = std::llround(t_s * 1e9);
        record.channel = static_cast<std::uint16_t>(c);
        record.value = (X * std::polar(1.0, theta)).imag() + noise * std::abs(X) * normal(rng);
        completed += (pipeline.push(record) & kCompleted) != 0;
      }
    }
    return completed;
  }
};

SlowRig slow_rig(double memory_s) {
  SlowRig slow;
  slow.chain = clamped_chain();
  slow.rig = rig_of(slow.chain, slow.frequency_hz);
  slow.rig.memory_s = memory_s;
  return slow;
}

TEST(SlowChange, AShakerThatDriftsATenthOfAPercentAMinuteIsFollowed) {
  SlowRig slow = slow_rig(60);
  slow.frequency_drift = 1e-3 / 60;
  Pipeline pipeline(slow.rig);
  EXPECT_EQ(slow.run(pipeline, 300), 0);
  ASSERT_EQ(pipeline.state(), State::measuring);
  const Dwell dwell = pipeline.current();
  const double middle_s = 0.5 * (dwell.settled_s + dwell.end_s);
  EXPECT_NEAR(dwell.frequency_hz.value, slow.frequency_at(middle_s), 2e-5 * slow.frequency_hz);
  expect_within(dwell, slow.chain, 4, "drifting");
  for (const ElementEstimate& element : dwell.elements) EXPECT_LT(element.stiffness.u, 2e-2 * element.stiffness.value);
  // The phase that is shown is the table's own, the drift in it.
  const double theta = 2 * M_PI * slow.frequency_hz * dwell.t_ref_s * (1 + 0.5 * slow.frequency_drift * dwell.t_ref_s);
  EXPECT_NEAR(std::remainder(std::arg(dwell.phasors[0].Y) - theta, 2 * M_PI), 0.0, 0.02);
  const double now_s = 300 - 1.0 / 200,
               now = 2 * M_PI * slow.frequency_hz * now_s * (1 + 0.5 * slow.frequency_drift * now_s);
  EXPECT_NEAR(std::remainder(std::arg(pipeline.phasor(0)) - now, 2 * M_PI), 0.0, 0.02);
}

TEST(SlowChange, TheUncertaintyOfAFrequencyThatDriftsCoversTheWholeDwell) {
  for (const double drift : {2e-4, 1e-3, 5e-3}) {
    SlowRig slow = slow_rig(60);
    slow.frequency_drift = drift / 60;
    Pipeline pipeline(slow.rig);
    slow.run(pipeline, 100);
    ASSERT_EQ(pipeline.state(), State::measuring);
    const Dwell dwell = pipeline.current();
    for (const double t_s : {dwell.settled_s, dwell.end_s})
      EXPECT_NEAR(dwell.frequency_hz.value, slow.frequency_at(t_s), 2.5 * dwell.frequency_hz.u) << drift << ", " << t_s;
    EXPECT_LT(dwell.frequency_hz.u, 2 * drift * slow.frequency_hz);
  }
}

// All masses answer otherwise at another frequency: no transducer is to blame.
TEST(SlowChange, AFrequencyThatDriftsBlamesNoTransducer) {
  SlowRig slow = slow_rig(600);
  slow.frequency_drift = 1e-3 / 60;
  slow.noise = 1e-5;
  Pipeline pipeline(slow.rig);
  slow.run(pipeline, 100);
  std::string all;
  for (const Warning& warning : pipeline.current().warnings) all += warning.what + "\n";
  EXPECT_EQ(all.find("check the transducer"), std::string::npos) << all;
  EXPECT_NE(all.find("the ratio of every channel to y0 varies"), std::string::npos) << all;
  EXPECT_NE(all.find("the drive's frequency drifts"), std::string::npos) << all;
}

// A rig of a long memory, from rest: the drift is in the fit of its transient, which would else take it for another
// mode.
TEST(SlowChange, ADriftHoldsNoVerdictUp) {
  Chain chain = clamped_chain();
  for (double& r : chain.damping) r *= 0.1;
  const double f = 5;
  const Rig rig = rig_of(chain, f);
  const auto steady = steady_response(chain, 2 * M_PI * f, 0.002);
  Sampling sampling{.rate_hz = 200, .sigma = {}};
  for (const Phasor& Y : steady.Y) sampling.sigma.push_back(1e-3 * std::abs(Y));
  sampling.sigma.push_back(1e-3 * std::abs(steady.F));
  double verdict_s[2] = {};
  for (const bool drifts : {false, true}) {
    Drive drive = steady_drive(f);
    Bench bench(chain, rig, drive, DrivenChain::Start::rest, sampling);
    const auto shake = [&] {
      drive.frequency_hz = f * (1 + (drifts ? 1e-3 / 60 : 0.0) * bench.now_s());
      bench.set_drive(drive);
      return bench.pipeline.state() == State::measuring;
    };
    bench.run(100, shake);
    ASSERT_EQ(bench.pipeline.state(), State::measuring);
    verdict_s[drifts] = bench.now_s();
    bench.run(verdict_s[drifts] + 30, [&] { return shake() && false; });
    const Dwell dwell = bench.pipeline.current();
    EXPECT_EQ(dwell.index, 1);
    expect_within(dwell, chain, 4, drifts ? "drifting" : "steady");
    for (std::size_t e = 0; e < dwell.elements.size(); ++e)
      EXPECT_LT(dwell.elements[e].stiffness.u, 1e-2 * chain.stiffness[e]) << e;
  }
  EXPECT_GT(verdict_s[0], 5 / slowest_decay_rate(chain));  // there is a transient to wait for
  EXPECT_LT(verdict_s[1], 1.25 * verdict_s[0]);
}

TEST(SlowChange, ARigThatWarmsUpIsFollowedAsFarAsTheMemoryResolves) {
  SlowRig slow = slow_rig(20);
  slow.stiffness_drift = -0.01 / 60;
  Pipeline pipeline(slow.rig);
  EXPECT_EQ(slow.run(pipeline, 180), 0);
  ASSERT_EQ(pipeline.state(), State::measuring);
  const Dwell dwell = pipeline.current();
  const auto& c = dwell.elements[0].stiffness;
  // The mean over the memory; within it the stiffness changes by a third of a percent.
  const double middle_s = 0.5 * (dwell.settled_s + dwell.end_s), now_s = dwell.end_s;
  EXPECT_NEAR(c.value, slow.at(middle_s).stiffness[0], 4 * c.u);
  EXPECT_NEAR(c.value, slow.at(now_s).stiffness[0], 4 * c.u + 0.002 * c.value);
  EXPECT_GT(dwell.settled_s, 155);
}

}  // namespace
}  // namespace dwell
