// A session of the estimation in virtual time on a simulated rig: its drive comes and goes, its interlock opens, its
// channels fall silent, its operator starts and stops runs. The stream is as a live service has it.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/model/driven_chain.hpp"
#include "daemon/estimate/estimator.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/daemon/collecting_sink.hpp"
#include "tests/durations.hpp"

namespace dwell::test {

class SimulatedSession {
 public:
  static constexpr std::int64_t kStart_ns = 5'000 * kMs_ns;

  // Scanned so many times a turn of 10 ms.
  SimulatedSession(const Chain& chain, double drive_hz, double noise, int scans, std::uint64_t seed,
                   bool bracketed = true, std::shared_ptr<LongWork> work = nullptr, double every_s = 1.0)
      : rig(rig_of(chain, drive_hz)),
        motion_(chain, {drive_hz, 0.0, 0.0, 0.0}, DrivenChain::Start::rest),
        drive_hz_(drive_hz),
        scans_(scans),
        random_(seed),
        noise_(0.0, noise) {
    LogOptions quiet;
    quiet.console = false;
    log_ = std::move(*Log::make(quiet));
    rig.devices = {{"amplifier", 0.0, 0.0}};
    std::vector<std::uint16_t> channels;
    for (Channel& channel : rig.channels) {
      channel.device = 0;
      channels.push_back(static_cast<std::uint16_t>(channels.size()));
    }
    rig.excitation.minimum = 1e-4;
    rig.channels[0].range.low = -1.0;
    rig.channels[0].range.high = 1.0;
    link_.emplace("amplifier", channels, 1u << 15, nullptr);
    EstimatorOptions options;
    options.gpio = &lines;
    options.long_work = std::move(work);
    options.runs = {bracketed, &sink, every_s, false};
    estimator.emplace(
        rig, std::vector<DeviceFeed>{{&*link_, "modbus", 100.0 * scans, false}}, options, *log_, [] {}, now_ns);
  }

  // The table's amplitude from now on, m; it takes 0.2 s.
  void drive(double amplitude) { motion_.set_drive(now_s(), {drive_hz_, amplitude, 0.0, 0.2}); }
  void interlock(bool closed) {
    (void)lines.push({.t_ns = now_ns - 3 * kMs_ns,
                      .value = closed ? 1.0 : 0.0,
                      .channel = static_cast<std::uint16_t>(Line::interlock),
                      .kind = Kind::edge});
  }
  // This channel delivers nothing from now on; -1: all deliver.
  void silence(int channel) { silent_ = channel; }
  // The next reading of the table is beyond its range.
  void spoil() { spoiled_ = true; }
  // A scan that comes half a second late.
  void late_scan() { scan(now_ns - 500 * kMs_ns); }

  void go_on(double seconds) {
    for (const std::int64_t end_ns = now_ns + std::llround(seconds * 1e9); now_ns < end_ns;) {
      now_ns += 10 * kMs_ns;
      for (int i = 0; i < scans_; ++i) scan(now_ns - 1 * kMs_ns - (scans_ - 1 - i) * (10 * kMs_ns / scans_));
      lines.seen_to(now_ns);
      estimator->turn(now_ns, now_ns + kUtc_ns);
    }
  }
  void finish() { estimator->finish(now_ns, now_ns + kUtc_ns); }
  const Snapshot& latest() {
    estimator->refresh();
    return estimator->latest();
  }
  // Changes of state and finished dwells since the last call.
  std::vector<RunEvent> events() {
    std::vector<RunEvent> all;
    for (RunEvent event; estimator->next_event(event);) all.push_back(event);
    return all;
  }

  static constexpr std::int64_t kUtc_ns = 1'700'000'000 * kSecond_ns;
  Rig rig;
  CollectingSink sink;
  gpio::Link lines;
  std::int64_t now_ns = kStart_ns;
  std::optional<Estimator> estimator;

 private:
  [[nodiscard]] double now_s() const { return 1e-9 * static_cast<double>(now_ns - kStart_ns); }
  void scan(std::int64_t t_ns) {
    const ChainMotion& moved = motion_.at(1e-9 * static_cast<double>(t_ns - kStart_ns));
    std::vector<dwell_sample> samples;
    for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c) {
      const double scale = rig.channels[static_cast<std::size_t>(c)].measures == Quantity::force ? 1e4 : 1.0;
      double value = exact_reading(rig, moved, c) + scale * noise_(random_);
      if (c == 0 && std::exchange(spoiled_, false)) value = 5.0;
      if (c != silent_) samples.push_back({t_ns, value, 1000, static_cast<std::uint16_t>(c), 0});
    }
    (void)link_->push(samples.data(), samples.size());
  }

  DrivenChain motion_;
  double drive_hz_;
  int scans_;
  std::mt19937_64 random_;
  std::normal_distribution<double> noise_;
  int silent_ = -1;
  bool spoiled_ = false;
  std::unique_ptr<Log> log_;
  std::optional<DeviceLink> link_;
};

}  // namespace dwell::test
