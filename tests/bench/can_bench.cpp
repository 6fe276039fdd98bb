// What the can plugin costs its thread per signal, from frames that come in batches through its local socket.
//
// Frames of four 16-bit signals (two Intel, two Motorola) are sent as fast as the plugin takes them, by a thread that
// waits while the socket is full, so that none is lost; the plugin's whole way is counted: system calls, stamps,
// decoding, handing over. Its CPU time alone counts, from one frame to another. Both threads share one processor.
#include <benchmark/benchmark.h>
#include <linux/can.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>

#include "daemon/acquire/plugin.hpp"
#include "daemon/clock.hpp"
#include "tests/bench/one_processor.hpp"
#include "tests/drivers/given.hpp"

namespace dwell {
namespace {

constexpr int kSignals = 4;
constexpr std::uint64_t kWarmUp = 2'000, kFrames = 100'000;

// Written on the plugin's thread.
struct Taken {
  std::uint64_t frames = 0, signals = 0;
  std::int64_t begin_ns = 0;
  std::atomic<std::int64_t> cpu_ns{0};
};

std::int32_t take(void* context, const dwell_sample*, std::size_t count) {
  Taken& taken = *static_cast<Taken*>(context);
  ++taken.frames;
  if (taken.frames == kWarmUp) taken.begin_ns = read_clock_ns(CLOCK_THREAD_CPUTIME_ID);
  if (taken.frames > kWarmUp) taken.signals += count;
  if (taken.frames == kWarmUp + kFrames) taken.cpu_ns = read_clock_ns(CLOCK_THREAD_CPUTIME_ID) - taken.begin_ns;
  return 1;
}

int listen_at(const std::string& path) {
  const int listener = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ::unlink(path.c_str());
  if (::bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 && ::listen(listener, 1) == 0)
    return listener;
  ::close(listener);
  return -1;
}

void send_all(int listener) {
  const int client = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
  canfd_frame frame{};
  frame.can_id = 0x123;
  frame.len = 8;
  for (std::uint64_t i = 0; i < kWarmUp + kFrames; ++i) {
    std::memcpy(frame.data, &i, sizeof i);
    if (::send(client, &frame, CAN_MTU, MSG_NOSIGNAL) < 0) break;
  }
  // The plugin still reads: what is on the way is lost with the socket.
  char end = 0;
  [[maybe_unused]] const auto got = ::recv(client, &end, 1, 0);
  ::close(client);
}

void can_signals(benchmark::State& state) {
  const auto table = acquire::load_plugin("can", {BENCH_PROGRAM_DIR});
  if (!table) return state.SkipWithError(table.error().c_str());
  const bench::OneProcessor processor;
  const std::string path = "/tmp/dwell-can-bench-" + std::to_string(::getpid());
  for (auto _ : state) {
    const int listener = listen_at(path);
    if (listener < 0) return state.SkipWithError("cannot listen");
    test::Given device("bench");
    device.set("interface", "unix:" + path);
    for (int i = 0; i < kSignals; ++i)
      device.channel("y" + std::to_string(i))
          .set("id", 0x123)
          .set("start", i % 2 == 0 ? 16 * i : 16 * i + 7)
          .set("length", 16)
          .set("order", i % 2 == 0 ? "intel" : "motorola")
          .set("type", "signed");
    Taken taken;
    dwell_host host{};
    host.size = sizeof host;
    host.context = &taken;
    host.push = &take;
    host.state = [](void*, std::int32_t, dwell_fault, const char*) {};
    host.count = [](void*, dwell_fault, std::uint64_t) {};
    host.log = [](void*, dwell_level, const char*) {};
    host.turn = [](void*) {};
    std::array<char, 256> error{};
    void* const instance = (*table)->create(device.settings(), &host, error.data(), error.size());
    if (instance == nullptr || (*table)->start(instance, error.data(), error.size()) != 0)
      return state.SkipWithError(error.data());
    std::thread sender([listener] { send_all(listener); });
    for (int i = 0; i < 20'000 && taken.cpu_ns == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    (*table)->stop(instance);
    (*table)->destroy(instance);
    sender.join();
    ::close(listener);
    ::unlink(path.c_str());
    if (taken.cpu_ns == 0 || taken.signals != kSignals * kFrames) return state.SkipWithError("not all frames arrived");
    state.counters["signals_per_s"] = 1e9 * static_cast<double>(taken.signals) / static_cast<double>(taken.cpu_ns);
  }
}
BENCHMARK(can_signals)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dwell
