#include "daemon/service.hpp"

#include <signal.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <utility>

#include "daemon/clock.hpp"
#include "daemon/log/throttle.hpp"
#include "daemon/notifier.hpp"
#include "daemon/serve/api.hpp"
#include "daemon/serve/control_server.hpp"
#include "daemon/serve/dwell_stream.hpp"
#include "daemon/serve/event_loop.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/session.hpp"
#include "daemon/version.hpp"
#include "daemon/watchdog.hpp"

namespace dwell {
namespace {

// A descriptor that is closed with its owner.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const noexcept { return number_; }

 private:
  int number_;
};

std::string iso_utc(std::int64_t utc_ns) {
  if (utc_ns == 0) return {};
  const auto seconds = static_cast<std::time_t>(utc_ns / 1'000'000'000);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char day[40];
  std::strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &parts);
  char text[64];
  std::snprintf(text, sizeof text, "%s.%06dZ", day, static_cast<int>(utc_ns / 1000 % 1'000'000));
  return text;
}

std::string status_line(const Snapshot& snapshot, const Health& health) {
  if (health.status == Health::Status::fault) return "not working: " + reason_of(health);
  std::string line = to_string(snapshot.dwell.state);
  if (snapshot.dwell.index) line += ", dwell " + std::to_string(*snapshot.dwell.index);
  if (snapshot.dwell.state == State::measuring && std::isfinite(snapshot.dwell.frequency_hz.value)) {
    char text[48];
    std::snprintf(text, sizeof text, ", %.4g Hz", snapshot.dwell.frequency_hz.value);
    line += text;
  }
  if (health.status != Health::Status::ok) line += "; " + reason_of(health);
  return line;
}

}  // namespace

struct Service::Impl {
  Impl(Log& the_log, int wake_descriptor) : log(the_log), wake(wake_descriptor) {}

  Log& log;
  EventLoop loop;
  Descriptor wake;  // the estimation thread has published
  std::optional<Descriptor> signals;
  Notifier notifier;
  Watchdog watchdog;
  std::string trouble;
  bool log_failing = false;
  Throttle log_failures;
  RunInfo run;
  std::vector<std::string> drivers;
  config::SchemaSource driver_source;
  std::int64_t started_ns = raw_now_ns();
  std::uint64_t told_sequence = 0;  // the newest snapshot that was broadcast
  DwellStream stream;
  std::unique_ptr<Session> session;
  std::unique_ptr<HttpServer> http;
  std::unique_ptr<ControlServer> control;

  [[nodiscard]] ServiceView view() {
    session->refresh();
    const Snapshot& snapshot = session->latest();
    if (run.start_utc.empty()) run.start_utc = iso_utc(snapshot.start_utc_ns);
    const std::int64_t now_ns = raw_now_ns();
    return {session->file().rig,
            drivers,
            run,
            snapshot,
            now_ns,
            static_cast<double>(now_ns - started_ns) * 1e-9,
            http ? http->stats() : HttpStats{},
            log.stats(),
            session->threads(),
            trouble,
            session->gpio()};
  }

  void published() {
    std::uint64_t count = 0;
    while (read(wake.get(), &count, sizeof count) > 0) {
    }
    if (!session) return;
    // Whoever asked by HTTP in between has taken the snapshot already: what counts is whether it was told.
    session->refresh();
    const std::uint64_t sequence = session->latest().sequence;
    if (sequence == told_sequence) return;
    told_sequence = sequence;
    tell_health();
    if (!http || http->stats().streams == 0) return;
    const ServiceView now = view();
    const DwellStream::Event event = stream.next(make_view(now.snapshot.dwell, now.rig, now.run), now.snapshot.t_ns);
    http->broadcast(event.name, event.data);
  }

  void tell_health() {
    const Health health = judge_health(session->file().rig, session->latest(), session->gpio(), log.stats(), trouble);
    session->light_lamps(health);
    notifier.status(status_line(session->latest(), health));
  }

  // Said where there is another place than the file, and in the file once it takes lines again.
  void watch_log() {
    const LogStats stats = log.stats();
    const std::string lost = std::to_string(stats.dropped) + " lines lost so far";
    // Each such line tries the file anew.
    if (stats.failing && log_failures.admit(raw_now_ns()))
      log.error("the log file does not take lines: " + stats.reason + "; " + lost);
    if (!stats.failing && log_failing) log.warning("the log file takes lines again; " + lost);
    log_failing = stats.failing;
  }

  // The loop turns, or this would not be called; the rest is looked at.
  void watch() {
    const std::string found = watchdog.judge(raw_now_ns(), session->threads(), session->rings());
    if (found.empty() != trouble.empty()) {
      if (found.empty()) {
        log.info("the service works again");
      } else {
        log.error("the service does not work: " + found);
      }
    }
    trouble = found;
    watch_log();
    tell_health();
    if (trouble.empty()) notifier.feed_watchdog();
  }

  void signalled() {
    signalfd_siginfo signal{};
    if (read(signals->get(), &signal, sizeof signal) != sizeof signal) return;
    if (signal.ssi_signo == SIGHUP) return check_rig_file();
    log.info(std::string("stopping: ") + strsignal(static_cast<int>(signal.ssi_signo)));
    loop.stop();
  }

  // What a restart would find. A rig file is not taken up while its rig is being measured.
  void check_rig_file() {
    const std::string& path = session->file().path;
    const auto file = config::load(path, driver_source);
    if (!file) {
      log.error("hangup: a restart would fail, for " + path + " now holds mistakes; the service goes on as it is");
      for (const config::Mistake& mistake : file.error()) log.error(config::to_string(path, mistake));
    } else if (file->sha256 == session->file().sha256) {
      log.info("hangup: " + path + " is what is being served");
    } else {
      log.warning("hangup: " + path +
                  " has changed and holds no mistake; to take it up, restart the service, which ends the dwell");
    }
  }

  std::string control_line(std::string_view line, const Peer& peer) {
    return control_answer(view(), line, [this, &peer] {
      log.info("rearm asked for by uid " + std::to_string(peer.uid) + ", pid " + std::to_string(peer.pid));
      return session->rearm();
    });
  }
};

sigset_t service_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  return signals;
}

Service::Service(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

tl::expected<std::unique_ptr<Service>, Service::Failure> Service::make(config::RigFile file,
                                                                       const config::SchemaSource& drivers,
                                                                       const ServiceOptions& options, Log& log) {
  const int wake = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (wake < 0) return tl::unexpected(Failure{1, "no descriptor is to be had"});
  auto impl = std::make_unique<Impl>(log, wake);
  Impl& self = *impl;

  self.run.rig_sha256 = file.sha256;
  self.run.version = kVersion;
  self.driver_source = drivers;
  for (const config::DeviceSettings& device : file.devices) self.drivers.push_back(device.driver);
  const config::ServerSettings server = file.server;

  auto session = Session::make(std::move(file), drivers, log, [wake] {
    const std::uint64_t one = 1;
    // Full means that the loop has been woken already.
    [[maybe_unused]] const auto written = write(wake, &one, sizeof one);
  });
  if (!session) return tl::unexpected(Failure{1, session.error()});
  self.session = std::move(*session);

  HttpOptions http_options;
  http_options.host = server.host;
  http_options.port = server.port;
  http_options.names = server.names;
  char own_name[HOST_NAME_MAX + 1] = {};
  if (gethostname(own_name, sizeof own_name - 1) == 0) http_options.names.emplace_back(own_name);
  http_options.names.push_back(server.host);
  http_options.server = std::string("dwelld/") + kVersion;
  auto http = HttpServer::make(
      self.loop, http_options,
      [&self](std::string_view path, std::string_view query) { return http_answer(self.view(), path, query); },
      [&self] {
        self.stream.joined();
        return event_text("dwell", dwell_text_json(self.view()));
      });
  if (!http) return tl::unexpected(Failure{http.error().bad_address ? 2 : 1, http.error().message});
  self.http = std::move(*http);
  if (self.http->awaits_address())
    log.warning("listen: " + server.listen +
                " is no address of this computer yet; clients are served as soon as it is, the rig is measured anyway");

  if (!options.control_path.empty()) {
    ControlOptions control_options;
    control_options.path = options.control_path;
    auto control = ControlServer::make(self.loop, control_options, [&self](std::string_view line, const Peer& peer) {
      return self.control_line(line, peer);
    });
    if (!control) return tl::unexpected(Failure{1, control.error()});
    self.control = std::move(*control);
  }

  if (options.handle_signals) {
    const sigset_t signals = service_signals();
    self.signals.emplace(signalfd(-1, &signals, SFD_NONBLOCK | SFD_CLOEXEC));
    if (self.signals->get() < 0) return tl::unexpected(Failure{1, "signals cannot be received"});
    self.loop.on_readable(self.signals->get(), [&self] { self.signalled(); });
  }
  self.loop.on_readable(wake, [&self] { self.published(); });
  constexpr std::int64_t kLongest_ms = 1000;
  const std::int64_t asked_ms = self.notifier.watchdog_ms() > 0 ? self.notifier.watchdog_ms() / 4 : kLongest_ms;
  self.loop.every(std::chrono::milliseconds(std::clamp<std::int64_t>(asked_ms, 10, kLongest_ms)),
                  [&self] { self.watch(); });

  if (auto started = self.session->start(); !started) return tl::unexpected(Failure{1, started.error()});
  return std::unique_ptr<Service>(new Service(std::move(impl)));
}

Service::~Service() = default;

void Service::run() {
  Impl& self = *impl_;
  self.log.info("serving rig \"" + self.session->file().rig.name + "\" on " + self.session->file().server.host +
                " port " + std::to_string(port()));
  self.notifier.ready();
  self.loop.run([&self](const char* failure) { self.log.error(std::string("event loop: ") + failure); });
  self.notifier.stopping();
  self.control.reset();
  self.http.reset();
  self.session.reset();
  self.log.info("stopped");
}

void Service::stop() { impl_->loop.stop(); }

std::uint16_t Service::port() const { return impl_->http->port(); }

}  // namespace dwell
