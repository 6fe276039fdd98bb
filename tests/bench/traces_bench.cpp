// What traces cost a sample: on the estimation thread (a queue takes it) and on the event loop; and what one answer
// costs.
#include <benchmark/benchmark.h>

#include <cmath>

#include "daemon/serve/traces_json.hpp"
#include "daemon/traces/trace_feed.hpp"
#include "daemon/traces/traces.hpp"

namespace dwell {
namespace {

constexpr std::size_t kChannels = 8;
constexpr std::int64_t kScan_ns = 1'000'000;  // 1 kHz

Rig rig_of_eight() {
  Rig rig;
  rig.channels.resize(kChannels);
  for (Channel& channel : rig.channels) channel.name = "y";
  return rig;
}

Record sample(std::int64_t scan, std::size_t channel) {
  return {.t_ns = scan * kScan_ns,
          .value = std::sin(0.025 * static_cast<double>(scan)),
          .channel = static_cast<std::uint16_t>(channel)};
}

constexpr std::size_t kBatch = 4096;  // taken out at once, as 20 times a second of 80 channels

void trace_feed(benchmark::State& state) {
  TraceFeed feed;
  std::size_t taken = 0;
  const Record record = sample(1, 1);
  for (auto _ : state) {
    for (std::size_t i = 0; i < kBatch; ++i) feed.take(record);
    state.PauseTiming();
    feed.drain([&](const Record&) { ++taken; });
    state.ResumeTiming();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(taken));
}
BENCHMARK(trace_feed);

void traces_take(benchmark::State& state) {
  Traces traces(rig_of_eight());
  std::vector<Record> records;
  for (std::int64_t scan = 0; scan < 1000; ++scan)
    for (std::size_t channel = 0; channel < kChannels; ++channel) records.push_back(sample(scan, channel));
  std::int64_t second = 0;
  for (auto _ : state) {
    for (Record record : records) {
      record.t_ns += second;
      traces.take(record);
    }
    second += 1'000'000'000;
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(records.size()));
}
BENCHMARK(traces_take);

// A whole window of a page: 10 s of 8 channels in bins of 20 ms; as a live event for three bins.
void traces_answer_window(benchmark::State& state) {
  const Rig rig = rig_of_eight();
  Traces traces(rig);
  for (std::int64_t scan = 0; scan < 60'000; ++scan)
    for (std::size_t channel = 0; channel < kChannels; ++channel) traces.take(sample(scan, channel));
  const RunInfo run;
  const Snapshot snapshot;
  ServiceView now{rig, run, snapshot};
  now.traces = &traces;
  for (auto _ : state) benchmark::DoNotOptimize(traces_answer(now, "from=-10&points=500").body.size());
}
BENCHMARK(traces_answer_window);

}  // namespace
}  // namespace dwell
