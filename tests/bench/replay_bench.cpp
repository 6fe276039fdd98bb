// `dwellctl replay` on ten minutes of eight channels at 1 kHz, the program's start and the comparison with what was
// stored once a second included; and what of it is reading the file.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "daemon/record/run_reader.hpp"
#include "tests/bench/steady_rig.hpp"
#include "tests/bench/steady_run.hpp"

namespace dwell {
namespace {

constexpr double kDuration_s = 600;

const std::string& run_file() { return steady_run(SteadyRig::kRate_hz, kDuration_s); }

void tell_speed(benchmark::State& state) {
  state.counters["times_real_time"] = benchmark::Counter(kDuration_s, benchmark::Counter::kIsIterationInvariantRate);
}

void replay_ten_minutes(benchmark::State& state) {
  const std::string command = std::string(BENCH_PROGRAM_DIR) + "/dwellctl replay " + run_file() + " >/dev/null";
  for (auto _ : state)
    if (std::system(command.c_str()) != 0) state.SkipWithError("the replay was not identical");
  tell_speed(state);
}
BENCHMARK(replay_ten_minutes)->Unit(benchmark::kMillisecond)->UseRealTime();

void reading_ten_minutes(benchmark::State& state) {
  std::uint64_t records = 0;
  for (auto _ : state) {
    auto reader = record::RunReader::open(run_file());
    if (!reader || !reader->stream([&](const Record&) { return ++records, true; }))
      state.SkipWithError("the file cannot be read");
  }
  benchmark::DoNotOptimize(records);
  tell_speed(state);
  state.counters["bytes"] = static_cast<double>(std::filesystem::file_size(run_file()));
}
BENCHMARK(reading_ten_minutes)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dwell
