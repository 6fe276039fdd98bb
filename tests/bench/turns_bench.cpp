// The longest turn: how long one push may hold up the thread that drains the rings, from the first sample of a rig to
// twenty seconds after its verdict. CPU time of this thread, so that what else the machine does is not counted; the
// longest of all pushes, not a mean.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <random>

#include "core/dwell/paced_pipeline.hpp"
#include "core/model/driven_chain.hpp"
#include "daemon/clock.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

// `state.range(0)` channels of a free chain at state.range(1) Hz each, from rest.
void longest_turn(benchmark::State& state) {
  constexpr double kFrequency_hz = 10.0, kSeconds = 40.0;
  const auto channels = static_cast<int>(state.range(0));
  const auto step_ns = static_cast<std::int64_t>(1e9 / static_cast<double>(state.range(1)));
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const Chain chain = random_chain(random, channels - 1, Boundary::free, kFrequency_hz);
  const Rig rig = rig_of(chain, kFrequency_hz);
  for (auto _ : state) {
    DrivenChain motion(chain, {.frequency_hz = kFrequency_hz, .amplitude = 2e-3, .ramp_s = 0.1},
                       DrivenChain::Start::rest);
    PacedPipeline pipeline(rig);
    std::int64_t longest_ns = 0, all_ns = 0, turns = 0;
    std::size_t most_waiting = 0;
    for (std::int64_t t_ns = 0; t_ns < static_cast<std::int64_t>(1e9 * kSeconds); t_ns += step_ns) {
      const ChainMotion& now = motion.at(1e-9 * static_cast<double>(t_ns));
      for (int c = 0; c < channels; ++c) {
        Record record;
        record.t_ns = t_ns;
        record.channel = static_cast<std::uint16_t>(c);
        record.value = now.y[static_cast<std::size_t>(c)] + 1e-6 * normal(random);
        const std::int64_t begin_ns = read_clock_ns(CLOCK_THREAD_CPUTIME_ID);
        pipeline.push(record);
        const std::int64_t took_ns = read_clock_ns(CLOCK_THREAD_CPUTIME_ID) - begin_ns;
        longest_ns = std::max(longest_ns, took_ns);
        all_ns += took_ns, ++turns;
        most_waiting = std::max(most_waiting, pipeline.waiting());
      }
    }
    state.counters["longest_ms"] = 1e-6 * static_cast<double>(longest_ns);
    state.counters["mean_ns"] = static_cast<double>(all_ns) / static_cast<double>(turns);
    state.counters["waiting"] = static_cast<double>(most_waiting);
    state.counters["settled"] = pipeline.pipeline().state() == State::measuring;
  }
}
BENCHMARK(longest_turn)->Args({64, 1000})->Args({16, 10000})->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dwell
