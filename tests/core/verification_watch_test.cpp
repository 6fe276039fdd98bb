#include "core/verify/verification_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

// A rig played from rest through a pipeline beside which the watch stands, as in the service.
struct WatchedBench {
  // mass: what the rig file states of the second, over what it is.
  explicit WatchedBench(double noise = 2e-3, double mass = 1.0) {
    const Rig true_rig = rig;
    rig.masses[1] *= mass;
    Sampling sampling{.rate_hz = 400, .skew_s = 0.0005, .sigma = {}};
    for (const Channel& channel : rig.channels)
      sampling.sigma.push_back(noise * (channel.measures == Quantity::force ? 50.0 : 5e-3));
    bench.emplace(chain, true_rig, Drive{.frequency_hz = 4.0, .amplitude = 5e-3, .ramp_s = 0.1},
                  DrivenChain::Start::rest, sampling, 1);
    bench->pipeline = Pipeline(rig);
    watch = VerificationWatch(rig);
    bench->alter = [this](Record&, double t_s) {
      if (t_s < next_s) return;
      next_s += 0.1;
      turn();
    };
  }
  void turn() {
    watch.take(bench->pipeline.readings(), 0);
    watch.follow(bench->pipeline.current());
    if (watch.due()) jobs.push_back(watch.hand_over());
    if (!jobs.empty() && gives_back) watch.take_back(jobs.back());
  }

  Chain chain = clamped_chain();
  Rig rig = rig_of(chain, 4.0);
  std::optional<Bench> bench;
  VerificationWatch watch{rig};
  std::vector<VerificationJob> jobs;
  double next_s = 0.0;
  bool gives_back = true;
};

TEST(VerificationWatch, AsksWhenTheDwellHasSettledAndEachTimeItsDataHaveDoubled) {
  WatchedBench watched;
  watched.bench->run(30.0);
  ASSERT_GE(watched.jobs.size(), 3u);
  EXPECT_LE(watched.jobs.size(), 9u);
  const double settled_s = watched.jobs[0].result.dwell.settled_s;
  EXPECT_LT(watched.jobs[0].result.dwell.end_s, watched.jobs[0].result.dwell.verdict_s + 0.5);
  for (std::size_t i = 1; i < watched.jobs.size(); ++i) {
    EXPECT_EQ(watched.jobs[i].evidence, watched.jobs[0].evidence) << "one record, shared";
    EXPECT_GE(watched.jobs[i].result.dwell.end_s - settled_s,
              2.0 * (watched.jobs[i - 1].result.dwell.end_s - settled_s) - 1e-9);
  }
}

TEST(VerificationWatch, VerifiesOnTheTransientThatTheRecordingHolds) {
  WatchedBench watched;
  watched.bench->run(30.0);
  watched.bench->finish();
  ASSERT_EQ(watched.bench->dwells.size(), 1u);
  watched.watch.ended(watched.bench->dwells[0]);
  ASSERT_TRUE(watched.watch.due());
  VerificationJob last = watched.watch.hand_over();
  EXPECT_EQ(last.result.dwell.state, State::complete);
  last.run(watched.rig, 0.05);
  EXPECT_EQ(last.result.verification.verdict, Verdict::adequate);
  EXPECT_TRUE(last.result.verification.consistent.value_or(false));
  watched.watch.take_back(std::move(last));
  ASSERT_TRUE(watched.watch.newest());
  EXPECT_EQ(watched.watch.newest()->dwell.index, 1);
}

TEST(VerificationWatch, KeepsTheEvidenceOfADwellThatEndsWhileTheNextSettles) {
  WatchedBench watched;
  watched.bench->run(20.0);
  const auto evidence = watched.jobs[0].evidence;
  Dwell next;
  next.index = 2;
  next.state = State::settling;
  next.start_s = 21.0;
  watched.watch.follow(next);
  Dwell before = watched.bench->pipeline.current();
  before.state = State::complete;
  watched.watch.ended(before);
  ASSERT_TRUE(watched.watch.due());
  EXPECT_EQ(watched.watch.hand_over().evidence, evidence);
}

// A long search for causes was out while two dwells ended: the first kept an earlier verdict for ever.
TEST(VerificationWatch, TheLastJobOfADwellWaitsBesideThatOfTheNext) {
  WatchedBench watched;
  watched.gives_back = false;
  watched.bench->run(20.0);
  ASSERT_EQ(watched.jobs.size(), 1u) << "it is out from here on";
  Dwell first = watched.bench->pipeline.current();
  Dwell second = first;
  second.index = 2;
  second.start_s = 21.0;
  second.settled_s = 22.0;
  second.end_s = 30.0;
  watched.watch.follow(second);
  first.state = second.state = State::complete;
  watched.watch.ended(first);
  watched.watch.ended(second);
  watched.watch.take_back(watched.jobs[0]);
  for (const int dwell : {1, 2}) {
    ASSERT_TRUE(watched.watch.due());
    VerificationJob job = watched.watch.hand_over();
    EXPECT_EQ(job.result.dwell.index, dwell);
    watched.watch.take_back(std::move(job));
  }
  EXPECT_FALSE(watched.watch.due());
}

TEST(VerificationWatch, LooksForCausesOnceForTheSameEvidence) {
  WatchedBench watched(2e-3, 1.1);
  watched.gives_back = false;
  watched.bench->run(12.0);
  ASSERT_EQ(watched.jobs.size(), 1u);
  watched.jobs[0].run(watched.rig, 0.05);
  ASSERT_TRUE(watched.jobs[0].causes);
  const auto causes = watched.jobs[0].causes;
  const std::vector<MissingTerm>& missing = watched.jobs[0].result.verification.missing;
  ASSERT_FALSE(missing.empty()) << causes->none;
  EXPECT_TRUE(std::any_of(missing.begin(), missing.end(), [](const MissingTerm& one) { return one.what == "mass 2"; }))
      << missing.front().what;
  watched.watch.take_back(watched.jobs[0]);
  ASSERT_TRUE(watched.watch.due());
  VerificationJob next = watched.watch.hand_over();
  EXPECT_EQ(next.causes, causes);
  next.run(watched.rig, 0.05);
  EXPECT_EQ(next.causes, causes);
  EXPECT_EQ(next.result.verification.missing.size(), missing.size());
}

TEST(VerificationWatch, HasOneJobOutAndOneOfADwellWaitingAtMost) {
  WatchedBench watched;
  watched.gives_back = false;
  watched.bench->run(30.0);
  EXPECT_EQ(watched.jobs.size(), 1u);
  EXPECT_FALSE(watched.watch.due());
  watched.watch.take_back(watched.jobs[0]);
  EXPECT_TRUE(watched.watch.due());
}

TEST(VerificationWatch, AsksNothingOfADwellThatDoesNotSettle) {
  WatchedBench watched;
  Dwell settling;
  settling.index = 1;
  settling.state = State::settling;
  settling.start_s = 0.0;
  watched.watch.follow(settling);
  EXPECT_FALSE(watched.watch.due());
  settling.state = State::complete;
  watched.watch.ended(settling);
  EXPECT_FALSE(watched.watch.due());
  EXPECT_FALSE(watched.watch.newest());
}

}  // namespace
}  // namespace dwell
