// What the modbus plugin costs its thread per poll, against a bare libmodbus loop on the same simulated rig.
//
// Both read the demo rig's five float32 in one transaction, back to back, each from a thread of its own whose CPU time
// alone counts. All of it shares one processor, so that each poll is the same two switches: free to wander, the same
// loop costs three times as much in one run as in the next. The plugin is asked for 100 kHz, more than any answer comes
// at, so that it never sleeps; telling the host of the deadlines that it misses for that is counted as its cost. Its
// timeout is the default one; with more than 0.35 s it makes one system call more per poll. A repetition is plugin,
// bare, bare, plugin: a machine that gets slower or faster meanwhile does so for both.
#include <benchmark/benchmark.h>
#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "daemon/acquire/plugin.hpp"
#include "daemon/clock.hpp"
#include "tests/bench/one_processor.hpp"
#include "tests/bench/simulated_rig.hpp"
#include "tests/drivers/given.hpp"

namespace dwell {
namespace {

constexpr int kWarmUp = 200, kPolls = 1500;
constexpr int kValues = 5;
constexpr double kFailed = -1.0;

// The CPU time of kPolls polls, read on the polling thread.
class Stopwatch {
 public:
  void poll_done() noexcept {
    ++polls_;
    if (polls_ == kWarmUp) begin_ns_ = read_clock_ns(CLOCK_THREAD_CPUTIME_ID);
    if (polls_ == kWarmUp + kPolls) cpu_ns_ = read_clock_ns(CLOCK_THREAD_CPUTIME_ID) - begin_ns_;
  }
  // s; negative if that takes longer than only a hang does. Another thread.
  [[nodiscard]] double wait() const {
    for (int i = 0; i < 20'000 && cpu_ns_ == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return cpu_ns_ == 0 ? kFailed : 1e-9 * static_cast<double>(cpu_ns_);
  }

 private:
  int polls_ = 0;
  std::int64_t begin_ns_ = 0;
  std::atomic<std::int64_t> cpu_ns_{0};
};

// CPU seconds of the plugin's thread; negative: failed.
double plugin_cpu_s(const dwell_driver_table& table, int port) {
  test::Given device("bench");
  device.set("transport", "tcp").set("host", "127.0.0.1").set("port", port).set("rate", 1e5).set("timeout", 0.1);
  for (int i = 0; i < kValues; ++i)
    device.channel("y" + std::to_string(i))
        .set("station", 1)
        .set("table", "input")
        .set("register", 2 * i)
        .set("type", "float32")
        .set("order", "abcd");

  Stopwatch stopwatch;
  dwell_host host{};
  host.size = sizeof host;
  host.context = &stopwatch;
  host.push = [](void* context, const dwell_sample*, std::size_t) -> std::int32_t {
    static_cast<Stopwatch*>(context)->poll_done();
    return 1;
  };
  host.state = [](void*, std::int32_t, dwell_fault, const char*) {};
  host.count = [](void*, dwell_fault, std::uint64_t) {};
  host.log = [](void*, dwell_level, const char*) {};
  host.turn = [](void*) {};

  std::array<char, 256> error{};
  void* const instance = table.create(device.settings(), &host, error.data(), error.size());
  if (instance == nullptr) return kFailed;
  const double cpu_s = table.start(instance, error.data(), error.size()) == 0 ? stopwatch.wait() : kFailed;
  table.stop(instance);
  table.destroy(instance);
  return cpu_s;
}

void poll_bare(int port, const std::atomic<bool>& stop, Stopwatch& stopwatch) {
  const std::unique_ptr<modbus_t, void (*)(modbus_t*)> context(modbus_new_tcp("127.0.0.1", port), &modbus_free);
  modbus_set_response_timeout(context.get(), 1, 0);
  modbus_set_slave(context.get(), 1);
  if (modbus_connect(context.get()) != 0) return;
  std::array<std::uint16_t, std::size_t{2} * kValues> registers{};
  while (!stop && modbus_read_input_registers(context.get(), 0, registers.size(), registers.data()) ==
                      static_cast<int>(registers.size())) {
    std::array<double, kValues> values{};
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = std::bit_cast<float>(std::uint32_t{registers[2 * i]} << 16U | registers[2 * i + 1]);
    benchmark::DoNotOptimize(values);
    stopwatch.poll_done();
  }
  modbus_close(context.get());
}

// CPU seconds of a thread that does nothing but libmodbus and decoding; negative: failed.
double bare_cpu_s(int port) {
  Stopwatch stopwatch;
  std::atomic<bool> stop{false};
  std::thread poller([&] { poll_bare(port, stop, stopwatch); });
  const double cpu_s = stopwatch.wait();
  stop = true;
  poller.join();
  return cpu_s;
}

void modbus_polls(benchmark::State& state) {
  const auto table = acquire::load_plugin("modbus", {BENCH_PROGRAM_DIR});
  if (!table) return state.SkipWithError(table.error().c_str());
  const bench::OneProcessor processor;
  const SimulatedRig rig(BENCH_PROGRAM_DIR "/rigsim");
  if (rig.port() == 0) return state.SkipWithError("rigsim does not start");
  for (auto _ : state) {
    std::array<double, 2> plugin{}, bare{};
    plugin[0] = plugin_cpu_s(**table, rig.port());
    for (double& cpu_s : bare) cpu_s = bare_cpu_s(rig.port());
    plugin[1] = plugin_cpu_s(**table, rig.port());
    if (std::min({plugin[0], plugin[1], bare[0], bare[1]}) < 0) return state.SkipWithError("the polls did not go on");
    const double plugin_s = plugin[0] + plugin[1], bare_s = bare[0] + bare[1];
    state.counters["plugin_polls_per_s"] = 2 * kPolls / plugin_s;
    state.counters["bare_polls_per_s"] = 2 * kPolls / bare_s;
    state.counters["ratio"] = bare_s / plugin_s;
  }
}
BENCHMARK(modbus_polls)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dwell
