// The way from a driver to the estimation thread, as the driver sees it: scans of eight samples through dwell_host.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

#include "daemon/acquire/device_link.hpp"

namespace dwell {
namespace {

constexpr std::size_t kScan = 8;
constexpr std::size_t kCapacity = 4096;
constexpr std::size_t kTaken = 256;  // samples that one call takes at most

DeviceLink link_of_eight() {
  std::vector<std::uint16_t> channels(kScan);
  std::iota(channels.begin(), channels.end(), std::uint16_t{0});
  return {"bench", channels, kCapacity, {}};
}

std::array<dwell_sample, kScan> scan() {
  std::array<dwell_sample, kScan> samples{};
  for (std::size_t i = 0; i < kScan; ++i) samples[i] = {1000, 0.5, 10, static_cast<std::uint16_t>(i), 0};
  return samples;
}

// What a sample costs on its way, both ends on one thread.
void ring_one_thread(benchmark::State& state) {
  DeviceLink link = link_of_eight();
  const dwell_host host = link.host();
  const auto samples = scan();
  std::array<Record, kTaken> taken{};
  for (auto _ : state) {
    for (std::size_t i = 0; i < kTaken / kScan; ++i) host.push(host.context, samples.data(), kScan);
    benchmark::DoNotOptimize(link.pop_samples(taken.data(), kTaken));
    benchmark::ClobberMemory();
  }
  if (link.left() != link.entered()) state.SkipWithError("samples were left behind");
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * kTaken));
}
BENCHMARK(ring_one_thread);

// One thread hands in, another takes, each as fast as it can. The producer waits for room: a refused scan is no
// throughput.
void ring_two_threads(benchmark::State& state) {
  constexpr std::uint64_t kSamples = std::uint64_t{1} << 20U;
  std::array<Record, kTaken> taken{};
  for (auto _ : state) {
    DeviceLink link = link_of_eight();
    std::thread driver([&link] {
      const dwell_host host = link.host();
      const auto samples = scan();
      for (std::uint64_t handed = 0; handed < kSamples; handed += kScan) {
        while (handed - link.left() + kScan > kCapacity) std::this_thread::yield();
        host.push(host.context, samples.data(), kScan);
      }
    });
    while (link.left() < kSamples)
      if (link.pop_samples(taken.data(), kTaken) == 0) std::this_thread::yield();
    driver.join();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * kSamples));
}
BENCHMARK(ring_two_threads)->UseRealTime();

}  // namespace
}  // namespace dwell
