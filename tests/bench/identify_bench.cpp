// A recording from its text to its coefficients: reading the CSV apart, then `dwellctl identify` on ten minutes.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "daemon/ctl/identify.hpp"
#include "drivers/replay/csv_recording.hpp"
#include "tests/bench/steady_rig.hpp"

namespace dwell {
namespace {

// skew_s: by which each channel is read after the one before; 0: all at one instant.
CsvRecording recording_of(SteadyRig& source, double duration_s, double skew_s) {
  CsvRecording recording;
  for (const Channel& channel : source.rig().channels) recording.channels.push_back(channel.name);
  const auto rows = std::llround(duration_s * SteadyRig::kRate_hz);
  recording.samples.reserve(static_cast<std::size_t>(rows) * recording.channels.size());
  for (long long row = 0; row < rows; ++row)
    for (int c = 0; c < source.channels(); ++c) {
      const double t_s = static_cast<double>(row) / SteadyRig::kRate_hz + c * skew_s;
      recording.samples.push_back({t_s, source.reading(c, t_s), static_cast<std::uint16_t>(c)});
    }
  return recording;
}

// The counter tells how much faster than it was recorded.
void identify_ten_minutes(benchmark::State& state, double skew_s) {
  constexpr double kDuration_s = 600;
  SteadyRig source;
  const ctl::CsvSource recording(source.rig(), recording_of(source, kDuration_s, skew_s));
  for (auto _ : state) {
    const auto dwells = ctl::identify(source.rig(), recording);
    if (!dwells || dwells->size() != 1 || dwells->front().elements.empty())
      state.SkipWithError("nothing was identified");
  }
  state.counters["times_real_time"] = benchmark::Counter(kDuration_s, benchmark::Counter::kIsIterationInvariantRate);
}
void identify_shared_instants(benchmark::State& state) { identify_ten_minutes(state, 0.0); }
void identify_own_instants(benchmark::State& state) { identify_ten_minutes(state, 1e-4); }
BENCHMARK(identify_shared_instants)->Unit(benchmark::kMillisecond);
BENCHMARK(identify_own_instants)->Unit(benchmark::kMillisecond);

// Wide: one row per instant.
std::string text_of(const CsvRecording& recording) {
  std::string text = "t";
  for (const std::string& name : recording.channels) text += "," + name;
  char cell[32];
  for (const CsvRecording::Sample& sample : recording.samples) {
    if (sample.column == 0) {
      std::snprintf(cell, sizeof cell, "\n%.3f", sample.t_s);
      text += cell;
    }
    std::snprintf(cell, sizeof cell, ",%.9g", sample.value);
    text += cell;
  }
  return text + "\n";
}

void csv_parsing(benchmark::State& state) {
  SteadyRig source;
  const std::string text = text_of(recording_of(source, 20, 0.0));
  std::size_t samples = 0;
  for (auto _ : state) {
    const auto recording = parse_csv(text, "bench.csv");
    if (!recording) return state.SkipWithError(recording.error().c_str());
    samples += recording->samples.size();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(samples));
}
BENCHMARK(csv_parsing)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dwell
