// Ten minutes of a chain of eight masses predicted from the table's readings.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/verify/virtual_test.hpp"

namespace dwell {
namespace {

constexpr int kMasses = 8;
constexpr std::int64_t kStep_ns = 1'000'000, kScans = 600'000;

Rig rig_of_masses() {
  Rig rig;
  rig.boundary = Boundary::clamped;
  rig.masses.assign(kMasses, 10.0);
  for (int k = 0; k <= kMasses + 1; ++k) {
    Channel channel;
    channel.at = k <= kMasses ? k : kGround;
    if (k > kMasses) channel.measures = Quantity::force;
    rig.channels.push_back(channel);
  }
  return rig;
}

// skew_ns: by which each channel is read after the one before. The spline through the table's readings is part of it.
void predict_ten_minutes(benchmark::State& state, std::int64_t skew_ns) {
  const Rig rig = rig_of_masses();
  const Chain chain{rig.boundary, rig.masses, std::vector<double>(kMasses + 1, 40000.0),
                    std::vector<double>(kMasses + 1, 60.0)};
  std::vector<Instants> instants(rig.channels.size());
  Eigen::MatrixXd table(1, kScans);
  for (std::int64_t i = 0; i < kScans; ++i) {
    table(0, i) = 1e-3 * std::sin(2 * M_PI * 4 * 1e-9 * static_cast<double>(kStep_ns * i));
    for (std::size_t c = 0; c < instants.size(); ++c)
      instants[c].push_back(kStep_ns * i + static_cast<std::int64_t>(c) * skew_ns);
  }
  const Instants of_table = instants[0];
  instants[0].clear();
  for (auto _ : state) {
    const VirtualTest test(rig, chain, 0);
    const VirtualTestInput input(of_table, table);
    benchmark::DoNotOptimize(test.play(input, Eigen::MatrixXd::Zero(test.model().states(), 1), instants));
  }
  state.counters["times_real_time"] = benchmark::Counter(600, benchmark::Counter::kIsIterationInvariantRate);
}
void virtual_test_shared_instants(benchmark::State& state) { predict_ten_minutes(state, 0); }
void virtual_test_own_instants(benchmark::State& state) { predict_ten_minutes(state, 100'000); }
BENCHMARK(virtual_test_shared_instants)->Unit(benchmark::kMillisecond);
BENCHMARK(virtual_test_own_instants)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dwell
