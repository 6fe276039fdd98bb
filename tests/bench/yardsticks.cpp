// What the harmonic fit is measured against, compiled into the same binary with the same flags:
//
//   least_work   a loop that does the least possible work for the same sums: one rotation and two products a harmonic,
//                instants taken as equally spaced. Nothing that a fit needs besides is done.
//   eigen_rls    recursive least squares on sin and cos of the harmonics and a mean, as one would write it with Eigen.
//   numpy_lstsq  numpy.linalg.lstsq over the same samples at once; by tests/bench/numpy_lstsq.py, in its own process.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

namespace dwell {
namespace {

constexpr int kHarmonics = 3, kScans = 1024;
constexpr double kAngle = 2 * M_PI * 10 * 1e-3;  // rad between two samples: 1 kHz and 10 Hz

std::vector<double> samples() {
  std::vector<double> out(kScans);
  for (int i = 0; i < kScans; ++i) out[static_cast<std::size_t>(i)] = 0.5 + 1e-3 * std::sin(kAngle * i);
  return out;
}

void least_work(benchmark::State& state) {
  const std::vector<double> readings = samples();
  std::array<double, kHarmonics> c, s, turn_c, turn_s, sum_c{}, sum_s{};
  for (std::size_t h = 0; h < kHarmonics; ++h) {
    const double angle = kAngle * static_cast<double>(h + 1);
    c[h] = 1.0, s[h] = 0.0, turn_c[h] = std::cos(angle), turn_s[h] = std::sin(angle);
  }
  double sum = 0.0, squares = 0.0;
  for (auto _ : state)
    for (const double y : readings) {
      for (std::size_t h = 0; h < kHarmonics; ++h) {
        sum_c[h] += y * c[h];
        sum_s[h] += y * s[h];
        const double turned = c[h] * turn_c[h] - s[h] * turn_s[h];
        s[h] = s[h] * turn_c[h] + c[h] * turn_s[h];
        c[h] = turned;
      }
      sum += y;
      squares += y * y;
    }
  benchmark::DoNotOptimize(sum_c);
  benchmark::DoNotOptimize(sum_s);
  benchmark::DoNotOptimize(sum + squares);
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kScans);
}
BENCHMARK(least_work);

void eigen_rls(benchmark::State& state) {
  constexpr int kUnknowns = 2 * kHarmonics + 1;
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  const std::vector<double> readings = samples();
  Eigen::Matrix<double, kUnknowns, kUnknowns> P = 1e6 * Eigen::Matrix<double, kUnknowns, kUnknowns>::Identity();
  Vector estimate = Vector::Zero();
  std::int64_t i = 0;
  for (auto _ : state)
    for (const double y : readings) {
      const double angle = std::remainder(kAngle * static_cast<double>(i++), 2 * M_PI);
      Vector x;
      x(0) = 1.0;
      for (int h = 1; h <= kHarmonics; ++h) x(2 * h - 1) = std::cos(h * angle), x(2 * h) = std::sin(h * angle);
      const Vector Px = P * x;
      const Vector gain = Px / (1.0 + x.dot(Px));
      estimate += gain * (y - x.dot(estimate));
      P -= gain * Px.transpose();
    }
  benchmark::DoNotOptimize(estimate);
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kScans);
}
BENCHMARK(eigen_rls);

// Asks the script once; its figure is a CPU time of that process.
void numpy_lstsq(benchmark::State& state) {
  for (auto _ : state) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> script(
        ::popen("/usr/bin/python3 " BENCH_SOURCE_DIR "/numpy_lstsq.py", "r"), &::pclose);
    double ns = 0.0;
    if (!script || std::fscanf(script.get(), "%lf", &ns) != 1) return state.SkipWithError("python3-numpy is needed");
    state.counters["ns"] = ns;
  }
}
BENCHMARK(numpy_lstsq)->Iterations(1);

}  // namespace
}  // namespace dwell
