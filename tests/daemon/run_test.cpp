// A run with its thread, and the end of many devices at once.
#include "daemon/run/run.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <future>
#include <iterator>
#include <mutex>
#include <thread>

#include "daemon/run/stop_together.hpp"
#include "tests/daemon/one_mass_rig.hpp"

namespace dwell {
namespace {

std::unique_ptr<Log> no_log() {
  LogOptions quiet;
  quiet.console = false;
  return std::move(*Log::make(quiet));
}

TEST(Run, CanBeReadToItsLastWordAfterItsEnd) {
  const auto log = no_log();
  config::RigFile file;
  file.sha256 = "abc";
  file.rig = test::one_mass_rig();
  file.rig.devices = {{"a"}};
  for (Channel& channel : file.rig.channels) channel.device = 0;
  DeviceLink link("a", {0, 1}, 4096, nullptr);
  std::promise<void> published;
  std::once_flag first;
  dwell::Run run(file, {{&link, "modbus", 200.0}}, nullptr, *log,
                 [&] { std::call_once(first, [&published] { published.set_value(); }); });
  EXPECT_FALSE(run.thread());
  run.start();
  ASSERT_TRUE(run.thread());
  EXPECT_EQ(run.thread()->name, "estimate");
  EXPECT_TRUE(run.rearm());
  published.get_future().wait();
  run.end();
  run.end();
  EXPECT_FALSE(run.thread());
  EXPECT_TRUE(run.refresh());
  EXPECT_EQ(run.latest().devices.at(0).name, "a");
  EXPECT_EQ(run.info().rig_sha256, "abc");
  EXPECT_EQ(run.info().start_utc.back(), 'Z') << run.info().start_utc;
}

TEST(Run, HasTwoThreadsForLongWorkWhereTheRigFileAsksForLiveVerification) {
  const auto threads = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
  };
  for (const bool live : {true, false}) {
    const auto log = no_log();
    config::RigFile file;
    file.rig = test::one_mass_rig();
    file.verification.live = live;
    dwell::Run run(file, {}, nullptr, *log, [] {});
    const auto before = threads();
    run.start();
    EXPECT_EQ(threads() - before, live ? 3 : 1) << "the estimation thread counts too";
    run.end();
  }
}

// A driver whose stop() waits until the test lets it go.
std::promise<void>& g_let_go = *new std::promise<void>;  // for ever: its threads may outlive main
std::shared_future<void>& g_gone = *new std::shared_future<void>(g_let_go.get_future().share());

const dwell_driver_table kHeld = [] {
  dwell_driver_table table{};
  table.size = sizeof table;
  table.abi = DWELL_DRIVER_ABI;
  table.name = "held";
  table.create = [](const dwell_settings*, const dwell_host*, char*, size_t) -> void* { return new int; };
  table.start = [](void*, char*, size_t) -> int32_t { return 0; };
  table.stop = [](void*) { g_gone.wait(); };
  table.destroy = [](void* instance) { delete static_cast<int*>(instance); };
  return table;
}();
const dwell_driver_table kWilling = [] {
  dwell_driver_table table = kHeld;
  table.stop = [](void*) {};
  return table;
}();

std::vector<std::shared_ptr<DeviceHost>> started(const dwell_driver_table& table) {
  std::vector<std::shared_ptr<DeviceHost>> devices;
  for (const char* name : {"a", "b", "c"}) {
    config::DeviceSettings settings;
    settings.name = name;
    settings.channels.emplace_back();
    devices.push_back(std::move(*DeviceHost::make(settings, "", table, nullptr)));
    EXPECT_TRUE(devices.back()->start());
  }
  return devices;
}

TEST(StopTogether, LeavesNobodyBehindWhereAllStop) {
  const auto devices = started(kWilling);
  EXPECT_TRUE(stop_together(devices, std::chrono::minutes(1)).empty());
  for (const auto& device : devices) EXPECT_EQ(device.use_count(), 1) << "the stopping threads have gone";
}

TEST(StopTogether, NamesAndCutsOffThoseThatDoNotReturn) {
  const auto devices = started(kHeld);
  EXPECT_EQ(stop_together(devices, std::chrono::milliseconds(50)), (std::vector<std::string>{"a", "b", "c"}));
  const dwell_sample sample{1, 1.0, 0, 0, 0};
  for (const auto& device : devices) {
    EXPECT_FALSE(device->link().push(&sample, 1)) << "what it still says goes nowhere";
    EXPECT_EQ(device.use_count(), 2) << "it lives for as long as its driver is in it";
  }
  g_let_go.set_value();
  for (const auto& device : devices)
    while (device.use_count() > 1) std::this_thread::yield();
}

}  // namespace
}  // namespace dwell
