// A service that measures the sample dwell: what the tests of its machine-read outlets are about.
#pragma once

#include <memory>

#include "daemon/alarms/alarm_list.hpp"
#include "daemon/service_view.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell::test {

struct MeasuredService {
  MeasuredService() {
    rig.devices = {{"amplifier"}};
    snapshot.sequence = 77;
    snapshot.t_ns = 9'900'000'000;
    snapshot.dwell = sample_dwell();
    snapshot.channels.resize(rig.channels.size());
    for (ChannelView& channel : snapshot.channels) {
      channel.fault = Fault::none;
      channel.heard_ns = 9'800'000'000;
      channel.rate_hz = 500.0;
      channel.tally = {10, 4, 1, 1, 1, 0, 1, 2};
    }
    snapshot.channels[2].fault = Fault::timeout;
    snapshot.devices.resize(1);
    snapshot.devices[0].name = "amplifier";
    snapshot.devices[0].driver = "modbus";
    snapshot.devices[0].up = true;
  }
  void verify(Verdict verdict) {
    auto verified = std::make_shared<VerifiedDwell>();
    verified->dwell = snapshot.dwell;
    verified->verification = sample_verification();
    verified->verification.verdict = verdict;
    snapshot.models = std::make_shared<VerifiedModels>(
        VerifiedModels{{snapshot.dwell.index.value_or(0), in_short(verified->verification)}});
    snapshot.verified = std::move(verified);
  }
  // Three alarms: one of each state.
  void raise_alarms() {
    constexpr std::int64_t kLong_ns = 2 * AlarmList::kLasts_ns;
    const std::vector<Trouble> troubles{{"channel:y0", "timeout"}, {"channel:y1", "timeout"}, {"log", "no room"}};
    (void)alarms.follow(troubles, {}, {0, 0});
    (void)alarms.follow(troubles, {}, {kLong_ns, kLong_ns});
    (void)alarms.acknowledge("log", "anna (uid 1000)", "", {kLong_ns, kLong_ns});
    (void)alarms.follow({troubles[0], troubles[2]}, {}, {2 * kLong_ns, 2 * kLong_ns});
  }
  // A chain of so many masses, each element measured: c = 1000 k, r = 10 k, U95 a hundredth of it.
  void chain_of(int masses) {
    rig.masses.assign(static_cast<std::size_t>(masses), 1.0);
    snapshot.dwell.elements.clear();
    for (int k = 1; k <= rig.element_count(); ++k) {
      ElementEstimate& element = snapshot.dwell.elements.emplace_back();
      element.k = k;
      element.identifiable = true;
      element.stiffness = {1000.0 * k, 5.0 * k, 1e3, 10.0 * k, true};
      element.damping = {10.0 * k, 0.05 * k, 1e3, 0.1 * k, true};
    }
  }
  // As it stands at now_ns; trouble: what the watchdog found.
  [[nodiscard]] ServiceView view(const std::string& trouble = {}) const {
    ServiceView now{rig, run, snapshot};
    now.now_ns = now_ns;
    now.uptime_s = 40.0;
    now.threads = {{"estimate", now_ns, 1'000'000'000}};
    now.gpio = gpio;
    now.recording.state = recorder;
    now.clients.http.requests = 12;
    now.clients.modbus = modbus;
    now.alarms = &alarms;
    now.clients.wrong_tokens = 3;
    now.health = judge_health(now.rig, now.snapshot, now.now_ns, now.gpio, now.log, trouble);
    return now;
  }

  Rig rig = sample_rig();
  RunInfo run = sample_run();
  Snapshot snapshot;
  gpio::Status gpio{};
  std::optional<record::RecorderState> recorder;
  std::optional<ModbusStats> modbus;
  AlarmList alarms;
  std::int64_t now_ns = 10'000'000'000;  // 0.1 s after the estimate
};

}  // namespace dwell::test
