// How much a recorder costs at 64 channels of 10 kHz, in real time: samples lost, the part of a core that its thread
// takes, bytes on the disk per sample.
//
// recorder_load [SECONDS] [each]: scans of eight channels, or with "each" every sample at its own instant.
#include <dirent.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "daemon/clock.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

constexpr int kChannels = 64, kScan = 8;
constexpr double kRate_hz = 10'000.0;
constexpr std::int64_t kPeriod_ns = 100'000, kStep_ns = 10'000'000;

// A vibration of 4 Hz on 16 bits with noise of a standard deviation of 20 steps, the host's stamps with jitter.
class Signal {
 public:
  Signal() {
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0.0, 20.0);
    for (double& value : noise_) value = noise(random);
  }
  double operator()(std::int64_t t_ns, int channel) {
    const double phase = 6.283185307179586 * 4.0 * static_cast<double>(t_ns) * 1e-9;
    return std::round((10'000.0 - 100.0 * channel) * std::sin(phase) + noise());
  }
  std::int64_t jitter_ns() { return static_cast<std::int64_t>(100.0 * noise()); }

 private:
  // Drawn at random from a table: walked through in order, it would repeat itself within a block, and compress.
  double noise() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return noise_[state_ >> 48];
  }

  double noise_[65536];
  std::uint64_t state_ = 88172645463325252u;
};

// User and system time of this process's thread of that name, s.
double thread_cpu_s(const std::string& name) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream stat(task.path() / "stat");
    std::string line;
    std::getline(stat, line);
    if (line.find("(" + name + ")") == std::string::npos) continue;
    long user = 0, system = 0;
    std::sscanf(line.c_str() + line.rfind(')') + 2, "%*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %ld %ld", &user,
                &system);
    return static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
  }
  return 0.0;
}

// One step of the stream, by channel or by instant; in the order of the instants, as a merger gives it.
void step(Recorder& recorder, Signal& signal, std::int64_t from_ns, bool each) {
  for (std::int64_t t_ns = from_ns; t_ns < from_ns + kStep_ns; t_ns += kPeriod_ns)
    for (int group = 0; group < kChannels / kScan; ++group) {
      std::int64_t scan_ns = t_ns + group * kPeriod_ns / (kChannels / kScan) + signal.jitter_ns() % 1000;
      for (int k = 0; k < kScan; ++k) {
        const int channel = group * kScan + k;
        if (each) scan_ns += 1000 + std::llabs(signal.jitter_ns()) % 300;
        recorder.record({.t_ns = scan_ns,
                         .stamped_ns = scan_ns,
                         .value = signal(t_ns, channel),
                         .t_half_ns = 5000,
                         .channel = static_cast<std::uint16_t>(channel)});
      }
    }
  recorder.record({.t_ns = from_ns + kStep_ns, .kind = Kind::tick});
}

int load(int seconds, bool each) {
  const Scratch scratch;
  Notices notices;
  RecorderOptions options = recorder_options(scratch.path(), notices);
  options.rate_hz = kChannels * kRate_hz;
  double cpu_s = 0.0, fullest = 0.0;
  std::uint64_t lost = 0;
  {
    Recorder recorder(options);
    Signal signal;
    std::int64_t t_ns = raw_now_ns();
    recorder.record({.t_ns = t_ns, .kind = Kind::run, .flags = static_cast<std::uint8_t>(RunEdge::armed)});
    recorder.record(
        {.t_ns = t_ns, .value = 1.0, .kind = Kind::run, .flags = static_cast<std::uint8_t>(RunEdge::begins)});
    const auto began = std::chrono::steady_clock::now();
    for (int n = 1; n <= seconds * 100; ++n, t_ns += kStep_ns) {
      step(recorder, signal, t_ns, each);
      if (n % 100 == 0) fullest = std::max(fullest, recorder.state(raw_now_ns()).buffer_fill);
      std::this_thread::sleep_until(began + n * std::chrono::nanoseconds(kStep_ns));
    }
    const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    cpu_s = thread_cpu_s("recorder") / took_s;
    lost = recorder.state(raw_now_ns()).lost_records;
    std::printf("%s: %d s of stream in %.1f s\n", each ? "each sample its own instant" : "scans of eight", seconds,
                took_s);
  }
  std::uint64_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scratch.path()))
    if (entry.path().extension() == ".dwell") bytes += entry.file_size();
  const double samples = kChannels * kRate_hz * seconds;
  std::printf("records lost %llu, recorder's thread %.3f of a core, buffer at most %.2f full, %.2f bytes per sample\n",
              static_cast<unsigned long long>(lost), cpu_s, fullest, static_cast<double>(bytes) / samples);
  return lost == 0 ? 0 : 1;
}

}  // namespace
}  // namespace dwell::record

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 60;
  return dwell::record::load(seconds, argc > 2 && std::strcmp(argv[2], "each") == 0);
}
