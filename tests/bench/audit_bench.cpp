// How fast `audit` reads, against sha256sum on the same file. The argument: readings a second of each of eight
// channels. At 25 Hz the results and notes are most of the file, at 1 kHz the readings.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "daemon/clock.hpp"
#include "daemon/record/audit.hpp"
#include "tests/bench/steady_run.hpp"

namespace dwell {
namespace {

// Of all children that have ended.
double children_cpu_s() {
  rusage usage{};
  ::getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void audit_over_sha256sum(benchmark::State& state) {
  const double rate_hz = static_cast<double>(state.range(0)), duration_s = state.range(0) < 500 ? 3600.0 : 600.0;
  const std::string& file = steady_run(rate_hz, duration_s);
  const std::string command = "sha256sum " + file + " >/dev/null";
  const auto bytes = static_cast<double>(std::filesystem::file_size(file));
  double audit_s = 0.0, yardstick_s = 0.0;
  for (auto _ : state) {
    const std::int64_t begun_ns = read_clock_ns(CLOCK_THREAD_CPUTIME_ID);
    const auto audit = record::audit_run(file, {});
    audit_s += 1e-9 * static_cast<double>(read_clock_ns(CLOCK_THREAD_CPUTIME_ID) - begun_ns);
    if (!audit || audit->state != record::AuditState::intact) return state.SkipWithError("the file is not intact");
    const double before_s = children_cpu_s();
    if (std::system(command.c_str()) != 0) return state.SkipWithError("no sha256sum");
    yardstick_s += children_cpu_s() - before_s;
  }
  state.counters["ratio"] = yardstick_s / audit_s;
  state.counters["bytes_per_s"] = static_cast<double>(state.iterations()) * bytes / audit_s;
  state.counters["recorded_bytes_per_s"] = bytes / duration_s;
}
BENCHMARK(audit_over_sha256sum)->Arg(25)->Arg(200)->Arg(1000);

}  // namespace
}  // namespace dwell
