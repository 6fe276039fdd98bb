// The sample path and identification, against one libm sincos.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <cmath>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "core/chain/identify.hpp"
#include "core/dwell/pipeline.hpp"
#include "core/fit/blocks.hpp"
#include "core/stream/merger.hpp"
#include "core/stream/scan_clocks.hpp"
#include "tests/bench/steady_rig.hpp"

namespace dwell {
namespace {

constexpr int kChannels = 8, kHarmonics = 3, kScans = 1024;
constexpr double kOmega = 2 * M_PI * 10;

void libm_sincos(benchmark::State& state) {
  std::vector<double> angles;
  angles.reserve(kScans);
  for (int i = 0; i < kScans; ++i) angles.push_back(std::remainder(0.01 * i, M_PI));
  for (auto _ : state)
    for (const double angle : angles) {
      double s = 0, c = 0;
      sincos(angle, &s, &c);
      benchmark::DoNotOptimize(s);
      benchmark::DoNotOptimize(c);
    }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kScans);
}
BENCHMARK(libm_sincos);

// kChannels at 1 kHz and 10 Hz; skew_ns 0: all at one instant.
void fit(benchmark::State& state, std::int64_t skew_ns) {
  Blocks blocks(kChannels, kHarmonics);
  const std::int64_t quarter_ns = 25'000'000, step_ns = 1'000'000;
  std::int64_t t = 0;
  blocks.open(0, quarter_ns, kOmega);
  for (auto _ : state)
    for (int i = 0; i < kScans; ++i, t += step_ns) {
      if (t >= blocks.open_end_ns()) {
        const std::int64_t end = blocks.open_end_ns();
        blocks.close();
        blocks.open(end, end + quarter_ns, kOmega);
      }
      for (int c = 0; c < kChannels; ++c) blocks.add(c, t + c * skew_ns, 0.5 + 1e-3 * c);
    }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kScans * kChannels);
}
void fit_own_instants(benchmark::State& state) { fit(state, 100'000); }
void fit_shared_instant(benchmark::State& state) { fit(state, 0); }
BENCHMARK(fit_own_instants);
BENCHMARK(fit_shared_instant);

// A minute of a rig's motion, its channels 0.1 ms apart, each instant late by up to so much.
std::vector<Record> minute_of(SteadyRig& source, std::int64_t jitter_ns = 0) {
  std::vector<Record> records;
  std::mt19937_64 rng(4);
  std::uniform_int_distribution<std::int64_t> late_ns(0, jitter_ns);
  for (int i = 0; i < 60'000; ++i)
    for (int c = 0; c < source.channels(); ++c) {
      Record record;
      record.t_ns = 1'000'000LL * i + 100'000LL * c + late_ns(rng);
      record.value = source.reading(c, 1e-9 * static_cast<double>(record.t_ns));
      record.channel = static_cast<std::uint16_t>(c);
      records.push_back(record);
    }
  return records;
}

// A device's own clock recovered: scans of `channels`, jittering by a millisecond at 1 kHz.
void device_clock(benchmark::State& state) {
  const auto channels = static_cast<std::uint16_t>(state.range(0));
  std::vector<std::uint16_t> indices(channels);
  std::iota(indices.begin(), indices.end(), std::uint16_t{0});
  std::mt19937_64 rng(5);
  std::uniform_int_distribution<std::int64_t> late_ns(0, 1'000'000);
  std::vector<std::int64_t> lateness(kScans);
  for (std::int64_t& late : lateness) late = late_ns(rng);
  ScanClocks clocks(Clock::device, indices, 0.0);
  std::int64_t t_ns = 0, sum = 0;
  for (auto _ : state)
    for (int i = 0; i < kScans; ++i, t_ns += 1'000'000) {
      Record record;
      record.t_ns = t_ns + lateness[static_cast<std::size_t>(i)];
      for (std::uint16_t c = 0; c < channels; ++c) {
        record.channel = c;
        clocks.push(record);
      }
      for (Record out; clocks.pop(out);) sum += out.t_ns;
    }
  benchmark::DoNotOptimize(sum);
  if (std::isnan(clocks.figures(0).rate_hz)) state.SkipWithError("no clock was found");
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kScans * channels);
}
BENCHMARK(device_clock)->Arg(1)->Arg(8);

// Every sample through the merger and the pipeline as in the service: the records of each turn of 10 ms are merged, and
// taken together within a block.
class Turns {
 public:
  explicit Turns(Pipeline& pipeline) : pipeline_(pipeline), merger_(2, 100'000'000, 4096) {}

  void play(const std::vector<Record>& records, std::int64_t later_ns) {
    for (Record record : records) {
      record.t_ns += later_ns;
      merger_.push(record.channel & 1, record);
      if (++pushed_ % kTurn == 0) take();
    }
  }

 private:
  static constexpr std::size_t kTurn = 10 * kChannels;  // records

  void take() {
    ready_.clear();
    for (Record out; merger_.pop(out);) ready_.push_back(out);
    for (std::span<const Record> left(ready_); !left.empty();) {
      std::size_t taken = pipeline_.push_in_block(left);
      if (taken == 0) pipeline_.push(left[taken++]);
      left = left.subspan(taken);
    }
  }

  Pipeline& pipeline_;
  Merger merger_;
  std::vector<Record> ready_;
  std::size_t pushed_ = 0;
};

void pipeline(benchmark::State& state) {
  SteadyRig source;
  const std::vector<Record> records = minute_of(source);
  for (auto _ : state) {
    Pipeline pipeline(source.rig());
    Turns(pipeline).play(records, 0);
    if (pipeline.state() != State::measuring) state.SkipWithError("the rig has not settled");
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * records.size()));
}
BENCHMARK(pipeline)->Unit(benchmark::kMillisecond);

// The same where nothing is left of the transient: the minutes after the first.
void later_minutes(benchmark::State& state, std::int64_t jitter_ns) {
  constexpr std::int64_t kMinute_ns = 60'000'000'000;
  SteadyRig source;
  const std::vector<Record> records = minute_of(source, jitter_ns);
  Pipeline pipeline(source.rig());
  Turns turns(pipeline);
  std::int64_t minutes = 0;
  turns.play(records, kMinute_ns * minutes++);
  for (auto _ : state) turns.play(records, kMinute_ns * minutes++);
  if (pipeline.state() != State::measuring) state.SkipWithError("the rig is not measured");
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * records.size()));
}
void pipeline_later(benchmark::State& state) { later_minutes(state, 0); }
void pipeline_jitter(benchmark::State& state) { later_minutes(state, 50'000); }
BENCHMARK(pipeline_later)->Unit(benchmark::kMillisecond);
BENCHMARK(pipeline_jitter)->Unit(benchmark::kMillisecond);

// The result with all its uncertainties, after a minute of data.
void publish(benchmark::State& state) {
  SteadyRig source;
  Pipeline pipeline(source.rig());
  for (const Record& record : minute_of(source)) pipeline.push(record);
  if (pipeline.state() != State::measuring) state.SkipWithError("the rig has not settled");
  for (auto _ : state) benchmark::DoNotOptimize(pipeline.current());
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(publish)->Unit(benchmark::kMicrosecond);

void identification(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  std::vector<double> masses(n);
  std::vector<Complex> Y(n + 1), d(n), Z(n + 1);
  for (double& m : masses) m = uniform(rng);
  for (Complex& y : Y) y = std::polar(uniform(rng), uniform(rng));
  for (std::size_t k = 0; k < n; ++k) d[k] = Y[k + 1] - Y[k];
  for (auto _ : state) {
    identify(Boundary::clamped, masses, kOmega, Y, d, {1.0, 0.5}, Z);
    benchmark::DoNotOptimize(Z.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * n));
}
BENCHMARK(identification)->Arg(1)->Arg(10)->Arg(100)->Arg(1000);

}  // namespace
}  // namespace dwell
