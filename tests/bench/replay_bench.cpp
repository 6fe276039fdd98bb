// `dwellctl replay` on ten minutes of eight channels at 1 kHz, the program's start and the comparison with what was
// stored once a second included; and what of it is reading the file.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/record/run_reader.hpp"
#include "tests/bench/steady_rig.hpp"
#include "tests/ctl/run_file_builder.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell {
namespace {

constexpr double kDuration_s = 600;

// The run file, made once.
const std::string& run_file() {
  static const test::TemporaryFolder folder;
  static const std::string path = [] {
    SteadyRig source;
    test::SimulatedRig rig;
    rig.chain.boundary = source.rig().boundary;
    rig.chain.masses = source.rig().masses;
    rig.frequency_hz = SteadyRig::kFrequency_hz;
    std::vector<Record> stream;
    const auto add = [&](double t_s, Kind kind, int channel, double value, std::uint8_t flags) {
      const std::int64_t t_ns = 1'000'000'000 + std::llround(1e9 * t_s);
      stream.push_back({.t_ns = t_ns,
                        .stamped_ns = t_ns,
                        .value = value,
                        .t_half_ns = 100'000,
                        .channel = static_cast<std::uint16_t>(channel),
                        .kind = kind,
                        .flags = flags});
    };
    add(0.0, Kind::run, 0, 0.0, static_cast<std::uint8_t>(RunEdge::armed));
    const auto scans = std::llround(kDuration_s * SteadyRig::kRate_hz);
    for (long long scan = 0; scan < scans; ++scan) {
      const double t_s = static_cast<double>(scan) / SteadyRig::kRate_hz;
      for (int c = 0; c < source.channels(); ++c) add(t_s, Kind::sample, c, 1e3 * source.reading(c, t_s), 0);
      if (scan % 10 == 9) add(t_s, Kind::tick, 0, 0.0, 0);
    }
    add(kDuration_s, Kind::run, 0, 0.0, static_cast<std::uint8_t>(RunEdge::ends));
    test::write_run(folder.path("run.dwell"), rig.rig_text(), stream, {.header = {}, .result = {}, .every_s = 1.0});
    return folder.path("run.dwell");
  }();
  return path;
}

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
