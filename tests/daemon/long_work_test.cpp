// The threads for what takes seconds, and the slots through which they get their work.
#include "daemon/estimate/long_work.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <stop_token>
#include <thread>

namespace dwell {
namespace {

Rig small_rig() {
  Rig rig;
  rig.masses = {2.0};
  rig.excitation.frequency_hz = 10.0;
  for (int at = 0; at < 2; ++at) {
    Channel channel;
    channel.at = at;
    rig.channels.push_back(channel);
  }
  return rig;
}

TEST(WorkSlot, HandsAJobThereAndBackOnce) {
  WorkSlot<int> slot;
  EXPECT_FALSE(slot.work([](int&) { FAIL() << "nothing waits"; }));
  EXPECT_FALSE(slot.collect());
  slot.put(1);
  EXPECT_FALSE(slot.free());
  EXPECT_FALSE(slot.collect()) << "not done yet";
  EXPECT_TRUE(slot.work([](int& job) { job += 1; }));
  EXPECT_FALSE(slot.work([](int&) { FAIL() << "done already"; }));
  EXPECT_FALSE(slot.free()) << "to be collected first";
  EXPECT_EQ(slot.collect(), 2);
  EXPECT_TRUE(slot.free());
}

TEST(LongWorkThread, DoesWhatIsPutIntoItsSlot) {
  const auto work = std::make_shared<LongWork>(small_rig(), 0.05);
  const LongWorkThread thread(work, LongWorkThread::Does::estimates);
  for (int i = 0; i < 20; ++i) {
    TransientJob job;
    job.stretch = static_cast<std::uint64_t>(i);
    work->estimates.put(std::move(job));
    std::optional<TransientJob> done;
    while (!(done = work->estimates.collect())) std::this_thread::yield();
    EXPECT_EQ(done->stretch, static_cast<std::uint64_t>(i));
    EXPECT_EQ(done->result.estimate.reason, "there are no readings");
  }
}

// Irregular instants that never repeat, at 1 kHz.
TransientJob job_of(std::int64_t readings) {
  TransientJob job;
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  for (std::int64_t i = 0; i < readings; ++i) {
    const std::int64_t t_ns = i * 997'001 + i * i % 1009 * 101;
    const double angle = 20.0 * std::numbers::pi * 1e-9 * static_cast<double>(t_ns);
    job.readings.push_back({t_ns, 1e-3 * (std::sin(angle - 0.1 * static_cast<double>(i % 2)) + 1e-3 * normal(rng)),
                            static_cast<int>(i % 2)});
  }
  return job;
}

TEST(LongWork, GivesAJobBackUndoneThatNobodyWantsAnyMore) {
  LongWork work(small_rig(), 0.05);
  TransientJob job = job_of(2'000);
  std::stop_source unwanted;
  unwanted.request_stop();
  job.stop = unwanted.get_token();
  work.estimates.put(std::move(job));
  EXPECT_TRUE(work.estimate());
  const std::optional<TransientJob> done = work.estimates.collect();
  ASSERT_TRUE(done);
  EXPECT_EQ(done->result.estimate.reason, "the estimate failed: nobody wants it any more");
  EXPECT_EQ(done->result.estimate.passes, 0);
}

TEST(LongWorkThread, EndsAtOnceWhateverItIsDoing) {
  const auto work = std::make_shared<LongWork>(small_rig(), 0.05);
  for (const auto does : {LongWorkThread::Does::estimates, LongWorkThread::Does::verifications}) {
    const LongWorkThread idle(work, does);
  }
  TransientJob long_job = job_of(2'000);  // some tenths of a second
  const auto before = std::chrono::steady_clock::now();
  {
    const LongWorkThread busy(work, LongWorkThread::Does::estimates);
    work->estimates.put(std::move(long_job));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // in the midst of it, on most machines
  }
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(5));
  // It is left to itself and ends in its own time; the test waits so that nothing runs on.
  while (work.use_count() > 1) std::this_thread::yield();
}

}  // namespace
}  // namespace dwell
