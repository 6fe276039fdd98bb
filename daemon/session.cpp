#include "daemon/session.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "daemon/acquire/device_host.hpp"
#include "daemon/acquire/hold_back.hpp"
#include "daemon/clock.hpp"
#include "daemon/estimate/estimation_thread.hpp"
#include "daemon/estimate/estimator.hpp"
#include "daemon/gpio/gpio_thread.hpp"
#include "daemon/gpio/kernel_lines.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kEstimateBound_ns = 2'000'000'000;
constexpr std::int64_t kDeviceBound_ns = 3'000'000'000;  // the interface asks for a turn every 0.5 s
constexpr std::chrono::seconds kStopWithin{1};           // the interface asks for half of that
constexpr std::int64_t kGpioBound_ns = 2'000'000'000;

EstimatorOptions options_for(const config::RigFile& file) {
  EstimatorOptions options;
  options.hold_back_ns = hold_back_ns(file);
  for (const config::DeviceSettings& device : file.devices) options.leads.push_back(device.leads);
  options.nominal_rate_hz.assign(file.rig.channels.size(), 0.0);
  for (const config::DeviceSettings& device : file.devices)
    for (const config::ChannelSettings& channel : device.channels)
      options.nominal_rate_hz[channel.index] = device.rate_hz.value_or(0.0);
  return options;
}

Level level_of(dwell_level level) {
  switch (level) {
    case DWELL_DEBUG:
      return Level::debug;
    case DWELL_INFO:
      return Level::info;
    case DWELL_WARNING:
      return Level::warning;
    case DWELL_ERROR:
      return Level::error;
  }
  return Level::error;
}

// A driver's own lines, at most so many a second; called on the driver's thread alone.
class DriverLines {
 public:
  DriverLines(std::string device, Log& log) : device_(std::move(device)), log_(log) {}
  void operator()(dwell_level level, const char* message) {
    const std::int64_t now_ns = raw_now_ns();
    if (now_ns - second_ns_ >= 1'000'000'000) {
      if (kept_back_ > 0)
        log_.warning("device " + device_ + ": " + std::to_string(kept_back_) + " lines of its driver left out");
      second_ns_ = now_ns;
      lines_ = kept_back_ = 0;
    }
    if (++lines_ > kLines) {
      ++kept_back_;
      return;
    }
    log_.write(level_of(level), "device " + device_ + ": " + message, {{"DWELL_DEVICE", device_}});
  }

 private:
  static constexpr int kLines = 20;
  std::string device_;
  Log& log_;
  std::int64_t second_ns_ = 0;
  int lines_ = 0;
  int kept_back_ = 0;
};

}  // namespace

struct Session::Impl {
  config::RigFile file;
  Log& log;
  std::vector<std::unique_ptr<DeviceHost>> devices;
  std::optional<gpio::GpioThread> gpio;
  std::optional<Estimator> estimator;
  std::optional<EstimationThread> thread;
};

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

tl::expected<std::unique_ptr<Session>, std::string> Session::make(config::RigFile file,
                                                                  const config::SchemaSource& drivers, Log& log,
                                                                  std::function<void()> published) {
  auto impl = std::unique_ptr<Impl>(new Impl{std::move(file), log, {}, {}, {}, {}});
  std::vector<DeviceLink*> links;
  for (const config::DeviceSettings& settings : impl->file.devices) {
    const auto table = drivers(settings.driver);
    if (!table) return tl::unexpected("device " + settings.name + ": " + table.error());
    if (const std::string note = config::rate_note(impl->file, settings); !note.empty()) log.info(note);
    auto device = DeviceHost::make(settings, impl->file.directory, **table, DriverLines(settings.name, log));
    if (!device) return tl::unexpected(device.error());
    links.push_back(&(*device)->link());
    impl->devices.push_back(std::move(*device));
  }
  EstimatorOptions options = options_for(impl->file);
  if (const config::GpioSettings& lines = impl->file.gpio;
      lines.interlock || lines.sync || lines.ready || lines.fault) {
    impl->gpio.emplace(lines, std::make_unique<gpio::KernelLines>(), log);
    options.gpio = &impl->gpio->link();
  }
  impl->estimator.emplace(impl->file.rig, std::move(links), options, log, std::move(published), raw_now_ns());
  return std::unique_ptr<Session>(new Session(std::move(impl)));
}

tl::expected<void, std::string> Session::start() {
  impl_->thread.emplace(*impl_->estimator);
  for (const auto& device : impl_->devices) {
    if (auto started = device->start(); !started) return started;
  }
  return {};
}

Session::~Session() {
  // What waits for a driver that may never return must not be this object's.
  struct Stopping {
    std::mutex mutex;
    std::condition_variable change;
    std::vector<bool> done;
    std::vector<std::unique_ptr<DeviceHost>> left_behind;  // end with the last of their threads, if these ever end
  };
  const auto stopping = std::make_shared<Stopping>();
  std::vector<std::thread> threads;
  stopping->done.resize(impl_->devices.size());
  // Each may take half a second; together they must not take longer.
  for (std::size_t i = 0; i < impl_->devices.size(); ++i)
    threads.emplace_back([stopping, i, device = impl_->devices[i].get()] {
      device->stop();
      const std::lock_guard lock(stopping->mutex);
      stopping->done[i] = true;
      stopping->change.notify_one();
    });
  std::vector<bool> stopped;
  {
    std::unique_lock lock(stopping->mutex);
    stopping->change.wait_for(lock, kStopWithin, [&stopping] {
      return std::all_of(stopping->done.begin(), stopping->done.end(), [](bool done) { return done; });
    });
    stopped = stopping->done;
  }
  impl_->thread.reset();
  for (std::size_t i = 0; i < threads.size(); ++i) {
    if (stopped[i]) {
      threads[i].join();
      continue;
    }
    DeviceLink& link = impl_->devices[i]->link();  // its driver may still be in it, for ever
    impl_->log.error("device " + link.name() +
                     ": its driver did not stop within 1 s and is left behind; the run is complete without it");
    link.abandon();
    {
      const std::lock_guard lock(stopping->mutex);
      stopping->left_behind.push_back(std::move(impl_->devices[i]));
    }
    threads[i].detach();
  }
}

const config::RigFile& Session::file() const noexcept { return impl_->file; }
bool Session::refresh() noexcept { return impl_->estimator->refresh(); }
const Snapshot& Session::latest() const noexcept { return impl_->estimator->latest(); }
bool Session::rearm() noexcept { return impl_->estimator->rearm(); }

gpio::Status Session::gpio() const { return impl_->gpio ? impl_->gpio->link().status() : gpio::Status{}; }

void Session::light_lamps(const Health& health) {
  if (impl_->gpio) impl_->gpio->link().order({health.ready, health.status != Health::Status::ok}, raw_now_ns());
}

std::vector<WatchedThread> Session::threads() const {
  std::vector<WatchedThread> threads;
  if (impl_->gpio) threads.push_back({"gpio", impl_->gpio->last_turn_ns(), kGpioBound_ns});
  if (impl_->thread) threads.push_back({"estimate", impl_->thread->last_turn_ns(), kEstimateBound_ns});
  const Snapshot& snapshot = latest();
  for (const auto& device : impl_->devices) {
    // A source that has been played to its end has nothing left to turn for.
    const auto& channels = device->link().channels();
    const bool ended = !channels.empty() && std::all_of(channels.begin(), channels.end(), [&](std::uint16_t channel) {
      return channel < snapshot.channels.size() && snapshot.channels[channel].fault == Fault::end_of_data;
    });
    if (!ended) threads.push_back({device->link().name(), device->link().last_turn_ns(), kDeviceBound_ns, false});
  }
  return threads;
}

std::vector<WatchedRing> Session::rings() const {
  std::vector<WatchedRing> rings;
  for (const auto& device : impl_->devices) {
    const std::uint64_t entered = device->link().entered();
    rings.push_back({device->link().name(), entered, device->link().left()});
  }
  return rings;
}

}  // namespace dwell
