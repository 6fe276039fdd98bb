#include "daemon/run/session.hpp"

#include <chrono>
#include <optional>
#include <utility>

#include "daemon/acquire/device_host.hpp"
#include "daemon/clock.hpp"
#include "daemon/gpio/gpio_thread.hpp"
#include "daemon/gpio/kernel_lines.hpp"
#include "daemon/log/driver_lines.hpp"
#include "daemon/run/recording.hpp"
#include "daemon/run/stop_together.hpp"

namespace dwell {
namespace {

// Longest delay of measuring while the recorder makes its first file. That takes about ten waits for the disk: 5 s at
// 0.5 s each. Halved: on such a disk a run that begins at once may lose more than 2 s. Doubled: a disk that hangs
// delays measuring by 10 s.
constexpr std::chrono::seconds kFirstFileLimit{5};
constexpr std::chrono::seconds kStopWithin{1};  // the interface asks for half of that
constexpr std::int64_t kGpioBound_ns = 2'000'000'000;
// A disk may hold the recorder up for so long: its buffer lasts longer. Beyond this the health reports it.
constexpr std::int64_t kRecordBound_ns = 10'000'000'000;

}  // namespace

struct Session::Impl {
  Impl(config::RigFile its_file, Log& its_log) : file(std::move(its_file)), log(its_log), traces(file.rig) {}

  config::RigFile file;
  Log& log;
  std::unique_ptr<record::Recorder> recorder;        // null: nothing is recorded
  std::vector<std::shared_ptr<DeviceHost>> devices;  // by RigFile::devices
  std::optional<gpio::GpioThread> gpio;
  std::unique_ptr<Outlet> lamps;
  TraceFeed trace_feed;  // from the run's thread to this one
  Traces traces;
  std::uint64_t traces_lost = 0;  // records lost on the way that the traces know of
  std::optional<Run> run;
  std::optional<OperatorRequests> operators;
};

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

tl::expected<std::unique_ptr<Session>, std::string> Session::make(config::RigFile file,
                                                                  const config::SchemaSource& drivers, Log& log,
                                                                  std::function<void()> wake) {
  auto impl = std::make_unique<Impl>(std::move(file), log);
  auto recorder = make_recorder(impl->file, drivers, log);
  if (!recorder) return tl::unexpected(std::move(recorder.error()));
  impl->recorder = std::move(*recorder);
  std::vector<DeviceFeed> feeds;
  for (const config::DeviceSettings& settings : impl->file.devices) {
    const auto table = drivers(settings.driver);
    if (!table) return tl::unexpected("device " + settings.name + ": " + table.error());
    if (const std::string note = config::rate_note(impl->file, settings); !note.empty()) {
      if (settings.asked_rate_hz)
        log.info(note);
      else
        log.warning(note);
    }
    if (const std::string note = config::line_note(settings); !note.empty()) log.warning(note);
    auto device =
        DeviceHost::make(settings, impl->file.directory, **table,
                         [lines = DriverLines(settings.name, log)](dwell_level level, const char* message) mutable {
                           lines.line(level, message, raw_now_ns());
                         });
    if (!device) return tl::unexpected(device.error());
    feeds.push_back(
        {&(*device)->link(), settings.driver, settings.rate_hz.value_or(0.0), settings.leads, settings.recorded});
    impl->devices.push_back(std::move(*device));
  }
  gpio::Link* edges = nullptr;
  if (const config::GpioSettings& lines = impl->file.gpio;
      lines.interlock || lines.sync || lines.ready || lines.fault) {
    impl->gpio.emplace(lines, std::make_unique<gpio::KernelLines>(), log);
    edges = &impl->gpio->link();
    impl->lamps = make_lamps(*edges);
  }
  impl->run.emplace(impl->file, std::move(feeds), edges, log, std::move(wake), impl->recorder.get(), &impl->trace_feed);
  impl->operators.emplace(*impl->run, log, impl->recorder.get());
  return std::unique_ptr<Session>(new Session(std::move(impl)));
}

tl::expected<void, std::string> Session::start() {
  if (impl_->recorder && !impl_->recorder->await_first_file(kFirstFileLimit))
    impl_->log.warning("recording: the disk has not answered for " + std::to_string(kFirstFileLimit.count()) +
                       " s; measuring begins before the first file is made");
  impl_->run->start();
  for (const auto& device : impl_->devices) {
    if (auto started = device->start(); !started) return started;
  }
  return {};
}

void Session::end() {
  const std::vector<std::string> left_behind = stop_together(impl_->devices, kStopWithin);
  impl_->run->end();
  impl_->devices.clear();  // not before: the run reads their rings to its end
  for (const std::string& name : left_behind)
    impl_->log.error("device " + name +
                     ": its driver did not stop within 1 s and is left behind; the run is complete without it");
}

Session::~Session() { end(); }

const config::RigFile& Session::file() const noexcept { return impl_->file; }
Run& Session::run() noexcept { return *impl_->run; }
OperatorRequests& Session::operators() noexcept { return *impl_->operators; }
gpio::Status Session::gpio() const { return impl_->gpio ? impl_->gpio->link().status() : gpio::Status{}; }
const Traces& Session::traces() {
  Impl& self = *impl_;
  self.trace_feed.drain([&self](const Record& record) { self.traces.take(record); });
  if (std::exchange(self.traces_lost, self.trace_feed.lost()) != self.traces_lost) self.traces.lost();
  const std::vector<ChannelView>& channels = self.run->latest().channels;
  for (std::size_t i = 0; i < channels.size(); ++i) self.traces.withhold(i, channels[i].condition == Condition::stuck);
  return self.traces;
}
Outlet* Session::lamps() noexcept { return impl_->lamps.get(); }
record::Recorder* Session::recorder() noexcept { return impl_->recorder.get(); }

std::vector<WatchedThread> Session::threads() const {
  std::vector<WatchedThread> threads;
  if (impl_->gpio) threads.push_back({"gpio", impl_->gpio->last_turn_ns(), kGpioBound_ns});
  if (const auto estimation = impl_->run->thread()) threads.push_back(*estimation);
  if (impl_->recorder) threads.push_back({"record", impl_->recorder->last_turn_ns(), kRecordBound_ns, false});
  const std::vector<DeviceView>& views = impl_->run->latest().devices;
  for (std::size_t i = 0; i < impl_->devices.size(); ++i) {
    if (i < views.size() && views[i].ended) continue;
    const DeviceLink& link = impl_->devices[i]->link();
    threads.push_back({link.name(), link.last_turn_ns(), DeviceIntake::kHung_ns, false});
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
