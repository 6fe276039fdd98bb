// The end of a session whose driver never returns.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <sstream>
#include <thread>

#include "daemon/run/session.hpp"

namespace dwell {
namespace {

// For ever: the driver's thread may outlive main.
std::promise<void>& g_release = *new std::promise<void>;  // what stop of the driver waits for
std::shared_future<void>& g_released = *new std::shared_future<void>(g_release.get_future().share());
std::promise<void>& g_destroyed = *new std::promise<void>;

const dwell_driver_table kHanging = [] {
  dwell_driver_table table{};
  table.size = sizeof table;
  table.abi = DWELL_DRIVER_ABI;
  table.name = "hanging";
  table.version = "0";
  table.help = "";
  table.create = [](const dwell_settings*, const dwell_host* host, char*, size_t) -> void* {
    return new dwell_host(*host);
  };
  table.start = [](void*, char*, size_t) -> int32_t { return 0; };
  table.stop = [](void* instance) {
    g_released.wait();
    // What a driver says long after it was given up goes nowhere.
    const auto* host = static_cast<const dwell_host*>(instance);
    host->log(host->context, DWELL_ERROR, "too late");
  };
  table.destroy = [](void* instance) {
    delete static_cast<dwell_host*>(instance);
    g_destroyed.set_value();
  };
  return table;
}();

TEST(SessionEnd, ADriverThatNeverStopsDoesNotKeepTheRunFromItsEnd) {
  const std::string file = std::filesystem::temp_directory_path() / ("dwell-end-" + std::to_string(::getpid()));
  std::atomic<int> published{0};
  {
    LogOptions options;
    options.console = false;
    options.file = file;
    auto log = Log::make(options);
    ASSERT_TRUE(log) << log.error();
    const config::SchemaSource drivers = [](std::string_view) -> tl::expected<const dwell_driver_table*, std::string> {
      return &kHanging;
    };
    auto rig = config::parse(
        "[rig]\nname = \"r\"\nmotion = \"translation\"\nboundary = \"clamped\"\nmasses = []\n[excitation]\nfrequency = "
        "4\nminimum = 1e-5\n[[device]]\nname = \"d\"\ndriver = \"hanging\"\n[[channel]]\nname = \"y0\"\ndevice = "
        "\"d\"\nmeasures = \"displacement\"\nat = 0\nunit = \"m\"\n[[channel]]\nname = \"f\"\ndevice = "
        "\"d\"\nmeasures = \"force\"\nat = \"ground\"\nunit = \"N\"\n",
        "rig.toml", drivers);
    ASSERT_TRUE(rig) << config::to_string("rig.toml", rig.error());
    auto session = Session::make(std::move(*rig), drivers, **log, [&published] { ++published; });
    ASSERT_TRUE(session) << session.error();
    ASSERT_TRUE((*session)->start());
    // Whoever ends the session is not kept by the driver: without the bound this waits for ever.
    auto ended = std::async(std::launch::async, [&session] { session->reset(); });
    const bool in_time = ended.wait_for(std::chrono::seconds(30)) == std::future_status::ready;
    EXPECT_TRUE(in_time);
    EXPECT_GE(published, 1) << "the end of the run";
    g_release.set_value();
    ended.wait();
    g_destroyed.get_future().wait();  // what was left behind goes once the driver returns
  }
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  EXPECT_NE(text.str().find("device d: its driver did not stop within 1 s"), std::string::npos) << text.str();
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace dwell
