// The pipeline's sample path must not touch the heap: not while idle, settling or measuring.
// operator new and Eigen both end in malloc, which this program puts in glibc's place.
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/stream/assembler.hpp"
#include "core/stream/scan_clocks.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/streaming_device.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DWELL_MALLOC_IS_THE_SANITIZERS 1
#else
#define DWELL_MALLOC_IS_THE_SANITIZERS 0
#endif

namespace {
thread_local bool forbidden = false;
thread_local int allocations = 0;
}  // namespace

#if !DWELL_MALLOC_IS_THE_SANITIZERS
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);

void* malloc(std::size_t size) {
  if (forbidden) ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  if (forbidden) ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  if (forbidden) ++allocations;
  return __libc_realloc(memory, size);
}
}
#endif

namespace dwell {
namespace {

TEST(PipelineAllocation, NoneFromTheFirstSampleToTheThousandthPeriod) {
  if (DWELL_MALLOC_IS_THE_SANITIZERS) GTEST_SKIP() << "malloc belongs to the sanitizer in this build";
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4);
  DrivenChain motion(chain, {.frequency_hz = 4, .amplitude = 0.002, .offset = 0, .ramp_s = 0, .harmonics = {}},
                     DrivenChain::Start::rest);
  std::vector<Record> stream;
  for (int i = 0; i < 50000; ++i)
    for (int c = 0; c < 4; ++c) {
      Record record;
      record.t_ns = 5'000'000LL * i + (c == 3 ? 1000 : 0);
      // Two seconds at rest, then the drive.
      record.value = i < 400 ? 0.0 : exact_reading(rig, motion.at(0.005 * (i - 400)), c);
      record.channel = static_cast<std::uint16_t>(c);
      if (c != 2 || i % 97 != 0) stream.push_back(record);  // a sample missing now and then
    }
  Pipeline pipeline(rig);
  // Two devices, the load cell one of its own; ticks and edges beside them, as the service has them.
  Assembler assembler({{Clock::host, {0, 1, 2}, 200.0, false}, {Clock::host, {3}, 200.0, false}}, 100'000'000, 1000);
  const auto enter = [](Record&) {};
  bool all_queued = true;
  const auto admitted = [&](const Record&, Merger::Admission admission) {
    all_queued = all_queued && admission == Merger::Admission::queued;
  };
  std::complex<double> sum = 0;
  bool idle = false, settling = false, measuring = false;
  forbidden = true;
  for (const Record& record : stream) {
    assembler.sample(record.channel == 3 ? 1 : 0, record, enter, admitted);
    if (record.channel == 3) {
      assembler.tick(record.t_ns);
      assembler.edges_seen_to(record.t_ns);
    }
    for (Record out; assembler.next(out);) {
      pipeline.push(out);
      idle = idle || pipeline.state() == State::idle;
      settling = settling || pipeline.state() == State::settling;
      measuring = measuring || pipeline.state() == State::measuring;
    }
    if (record.t_ns % 1'000'000'000 == 0) sum += pipeline.phasor(0);
  }
  forbidden = false;
  EXPECT_EQ(allocations, 0);
  forbidden = true;
  std::free(std::malloc(sum != 0.0 ? 1 : 2));  // the guard itself sees an allocation
  forbidden = false;
  EXPECT_EQ(allocations, 1);
  EXPECT_TRUE(idle && settling && measuring);
  EXPECT_TRUE(all_queued);
}

TEST(ScanClocksAllocation, NoneWhileAClockIsFoundFollowedAndLost) {
  if (DWELL_MALLOC_IS_THE_SANITIZERS) GTEST_SKIP() << "malloc belongs to the sanitizer in this build";
  StreamingDevice device;
  device.lost = 0.01;
  device.stall_every_s = 1.0;
  std::mt19937_64 rng(1);
  std::vector<Arrival> stream = arrivals(device, 0.0, 10.0, rng);
  for (const Arrival& arrival : arrivals(device, 15.0, 20.0, rng)) stream.push_back(arrival);
  ScanClocks clocks(Clock::device, {0, 1}, 1000.0);
  std::size_t given = 0;
  allocations = 0;
  forbidden = true;
  for (const Arrival& arrival : stream) {
    Record record;
    record.t_ns = arrival.arrival_ns;
    for (record.channel = 0; record.channel < 2; ++record.channel) clocks.push(record);
    clocks.wait(arrival.arrival_ns);
    for (Record out; clocks.pop(out);) ++given;
  }
  clocks.flush();
  for (Record out; clocks.pop(out);) ++given;
  forbidden = false;
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(given, 2 * stream.size());
  EXPECT_EQ(clocks.figures(0).relocked, 1u);
}

}  // namespace
}  // namespace dwell
