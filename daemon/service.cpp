#include "daemon/service.hpp"

#include <signal.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cstring>
#include <optional>
#include <utility>

#include "daemon/alarms/alarms.hpp"
#include "daemon/clock.hpp"
#include "daemon/notifier.hpp"
#include "daemon/outlets/http.hpp"
#include "daemon/outlets/outlet.hpp"
#include "daemon/outlets/plc.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/run/countersigner.hpp"
#include "daemon/run/recording.hpp"
#include "daemon/run/session.hpp"
#include "daemon/serve/api.hpp"
#include "daemon/serve/control_server.hpp"
#include "daemon/serve/event_loop.hpp"
#include "daemon/service_watch.hpp"
#include "daemon/version.hpp"

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

// What a restart would find. A rig file is not taken up while its rig is being measured.
void check_rig_file(const config::RigFile& served, const config::SchemaSource& drivers, Log& log) {
  const std::string& path = served.path;
  const auto file = config::load(path, drivers);
  if (!file) {
    log.error("hangup: a restart would fail, for " + path + " now holds mistakes; the service goes on as it is");
    for (const config::Mistake& mistake : file.error()) log.error(config::to_string(path, mistake));
  } else if (file->sha256 == served.sha256) {
    log.info("hangup: " + path + " is what is being served");
  } else {
    log.warning("hangup: " + path +
                " has changed and holds no mistake; to take it up, restart the service, which ends the dwell");
  }
}

HttpOptions http_options(const config::ServerSettings& server) {
  HttpOptions options;
  options.host = server.listen.host;
  options.port = server.listen.port;
  options.names = server.names;
  char own_name[HOST_NAME_MAX + 1] = {};
  if (gethostname(own_name, sizeof own_name - 1) == 0) options.names.emplace_back(own_name);
  options.names.push_back(server.listen.host);
  options.server = std::string("dwelld/") + kVersion;
  return options;
}

}  // namespace

// Its steps of making return what failed; nothing: it is done.
struct Service::Impl {
  using Made = tl::expected<void, Failure>;

  Impl(Log& the_log, const config::SchemaSource& the_drivers, std::int64_t start_patience_ns)
      : log(the_log), drivers(the_drivers), watch(the_log), starts(start_patience_ns) {}

  Log& log;
  const config::SchemaSource drivers;
  const std::int64_t started_ns = raw_now_ns();
  EventLoop loop;
  Descriptor wake{eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};  // the run has something new
  Notifier notifier;
  ServiceWatch watch;
  std::unique_ptr<Outlet> log_lines = make_log_lines(log);
  std::unique_ptr<Outlet> systemd = make_systemd_status(notifier);
  std::unique_ptr<Session> session;
  std::optional<Rights> rights;
  Alarms alarms{log, [this](record::StoredEvent event) {
                  if (record::Recorder* const recorder = session->recorder()) recorder->event(std::move(event));
                }};
  std::unique_ptr<Http> http;
  std::unique_ptr<Plc> plc;  // null: the rig file has no [modbus_server]
  std::unique_ptr<ControlServer> control;
  std::optional<Countersigner> signer;  // none: nothing is recorded
  AwaitedStarts starts;

  // As all stands now.
  [[nodiscard]] ServiceView view() {
    Run& run = session->run();
    run.refresh();
    ServiceView now{session->file().rig, run.info(), run.latest()};
    now.now_ns = raw_now_ns();
    now.now_utc_ns = utc_now_ns();
    now.uptime_s = static_cast<double>(now.now_ns - started_ns) * 1e-9;
    if (http) now.clients.http = http->server().stats();
    if (rights) now.clients.wrong_tokens = rights->failures();
    if (plc) now.clients.modbus = plc->server().stats();
    now.log = log.stats();
    now.events = &log.newest();
    now.alarms = &alarms.list();
    now.threads = session->threads();
    now.gpio = session->gpio();
    now.traces = &session->traces();
    now.verification = session->file().verification;
    if (record::Recorder* const recorder = session->recorder()) {
      now.recording.state = recorder->state(now.now_ns);
      now.recording.runs = recorder->runs();
      now.recording.audits = recorder->audits();
    }
    now.clock_synchronized = record::clock_synchronized();
    now.health = judge_health(now.rig, now.snapshot, now.now_ns, now.gpio, now.log, watch.trouble(),
                              now.recording.state ? now.recording.state->alarms : std::vector<record::RecorderAlarm>(),
                              now.clock_synchronized, now.now_utc_ns);
    return now;
  }

  void each_outlet(const std::function<void(Outlet&)>& call) {
    call_each({log_lines.get(), session->lamps(), systemd.get(), http.get(), plc.get()}, call);
  }
  void tell_events() {
    for (RunEvent event; session->run().next_event(event);)
      each_outlet([&](Outlet& outlet) { outlet.tell(event, session->file().rig); });
  }
  void show() {
    const ServiceView now = view();
    alarms.look(now.health, {now.now_ns, now.now_utc_ns});
    if (now.recording.state) starts.look(*now.recording.state, now.now_ns);
    tell_events();
    each_outlet([&](Outlet& outlet) { outlet.show(now); });
  }

  void woken() {
    std::uint64_t count = 0;
    while (read(wake.get(), &count, sizeof count) > 0) {
    }
    show();
  }

  // The loop turns, or this would not be called; the rest is looked at.
  void look() {
    watch.look(raw_now_ns(), session->threads(), session->rings());
    if (record::Recorder* const recorder = session->recorder(); recorder != nullptr && recorder->take_restart())
      (void)session->run().restart();
    show();
    if (watch.trouble().empty()) notifier.feed_watchdog();
  }

  void signalled(int descriptor) {
    signalfd_siginfo signal{};
    if (read(descriptor, &signal, sizeof signal) != sizeof signal) return;
    if (signal.ssi_signo == SIGHUP) {
      renew_rights();
      return check_rig_file(session->file(), drivers, log);
    }
    log.info(std::string("stopping: ") + strsignal(static_cast<int>(signal.ssi_signo)));
    loop.stop();
  }

  // The token file may have changed. One that cannot be used leaves the old token in force: a slip lets nobody in.
  void renew_rights() {
    const config::RigFile& file = session->file();
    auto access = read_access(file.server);
    if (!access) {
      log.error("hangup: the token stays as it was, for what is there now cannot be used");
      for (const config::Mistake& mistake : access.error()) log.error(config::to_string(file.path, mistake));
    } else if (rights->renew(std::move(*access))) {
      log.info("hangup: another token counts from now on");
      http->end_streams();
    }
  }

  tl::expected<void, std::string> operate(const OperatorRequest& request, const record::Person& by) {
    if (request.verb != OperatorRequest::Verb::acknowledge) return session->operators().ask(request, by);
    return alarms.acknowledge(request.alarm, request.comment, by, {raw_now_ns(), utc_now_ns()});
  }

  // A start is answered once it is known whether its run is recorded.
  ControlReply control_line(std::string_view line, const Peer& peer) {
    if (auto asked = parse_sign_request(line, peer.uid)) return sign(std::move(*asked), peer);
    std::uint16_t start = 0;
    std::string said = control_answer(view(), line, [&](const OperatorRequest& request) {
      auto done = operate(request, {peer.uid, user_name(peer.uid)});
      if (done && request.verb == OperatorRequest::Verb::start) start = session->operators().newest();
      return done;
    });
    if (start == 0 || session->recorder() == nullptr) return said;
    return ControlReply([this, start](const ControlReply::Answer& answer) {
      starts.add(start, raw_now_ns(), [answer](const StartOutcome& outcome) {
        const auto known = start_answer(outcome);
        answer(known ? *known : dump(Json{{"error", known.error()}}));
      });
    });
  }

  ControlReply sign(record::Result<SignRequest> asked, const Peer& peer) {
    if (!asked) return sign_answer(tl::unexpected(asked.error()));
    if (!signer)
      return sign_answer(tl::unexpected(std::string("the service records no runs; sign with a key of your own")));
    log.info((asked->enter ? "entry of the signatures under " : "signature under ") + printable(asked->file) +
             " asked for by uid " + std::to_string(peer.uid) + ", pid " + std::to_string(peer.pid));
    return ControlReply([this, request = std::move(*asked)](const ControlReply::Answer& answer) {
      signer->ask(request, [this, answer](const record::Result<Signed>& made) {
        loop.post([this, answer, made] {
          if (!made)
            log.info("neither signed nor entered: " + printable(made.error()));
          else if (made->signature)
            log.info("run " + std::to_string(made->run) + " signed by " + made->signature->name);
          else if (made->entered > 0)
            log.info("run " + std::to_string(made->run) +
                     ": signatures entered into the ledger: " + std::to_string(made->entered));
          answer(sign_answer(made));
        });
      });
    });
  }

  Made make_rights(const config::RigFile& file) {
    auto access = read_access(file.server);
    if (!access) return tl::unexpected(Failure{2, config::to_string(file.path, access.error().front())});
    if (file.modbus_server)
      if (const auto open = check_modbus_access(*file.modbus_server); !open)
        return tl::unexpected(Failure{2, config::to_string(file.path, open.error().front())});
    rights.emplace(std::move(*access), log);
    return {};
  }

  Made make_session(config::RigFile file) {
    if (wake.get() < 0) return tl::unexpected(Failure{1, "no descriptor is to be had"});
    auto made = Session::make(std::move(file), drivers, log, [descriptor = wake.get()] {
      const std::uint64_t one = 1;
      // Full means that the loop has been woken already.
      [[maybe_unused]] const auto written = write(descriptor, &one, sizeof one);
    });
    if (!made) return tl::unexpected(Failure{1, made.error()});
    session = std::move(*made);
    if (record::Recorder* const recorder = session->recorder())
      signer.emplace(recording_directory(session->file()),
                     [recorder](std::int64_t run, const record::PersonalSignature& signature) {
                       return recorder->run_signed(run, signature);
                     });
    loop.on_readable(wake.get(), [this] { woken(); });
    return {};
  }

  void warn_of_address(const std::string& table, const std::string& listen) {
    log.warning(table + " listen: " + listen +
                " is no address of this computer yet; clients are served as soon as it is, the rig is measured anyway");
  }

  Made make_http(const std::string& page_folder) {
    const config::ServerSettings& server = session->file().server;
    PageFiles page = page_folder.empty() ? PageFiles() : PageFiles::read(page_folder);
    if (!page_folder.empty() && !page.trouble().empty()) log.warning("no page for operators: " + page.trouble());
    HttpContent content{[this] { return view(); }, std::move(page), &*rights};
    content.operate = [this](const OperatorRequest& request, const record::Person& by) { return operate(request, by); };
    if (session->recorder() != nullptr)
      content.await_start = [this](std::function<void(const StartOutcome&)> tell) {
        starts.add(session->operators().newest(), raw_now_ns(), std::move(tell));
      };
    auto made = Http::make(loop, http_options(server), std::move(content));
    if (!made) return tl::unexpected(Failure{made.error().bad_address ? 2 : 1, made.error().message});
    http = std::move(*made);
    if (http->server().stats().awaits_address) warn_of_address("[server]", server.listen.text);
    return {};
  }

  Made make_plc() {
    const auto& server = session->file().modbus_server;
    if (!server) return {};
    ModbusOptions options;
    options.host = server->listen.host;
    options.port = server->listen.port;
    auto made = Plc::make(loop, options);
    if (!made)
      return tl::unexpected(Failure{made.error().bad_address ? 2 : 1, "[modbus_server] " + made.error().message});
    plc = std::move(*made);
    log.info("serving PLCs on " + options.host + " port " + std::to_string(plc->server().port()) +
             "; Modbus knows no rights: whoever reaches this address can read, and nobody can write");
    if (plc->server().stats().awaits_address) warn_of_address("[modbus_server]", server->listen.text);
    return {};
  }

  Made make_control(const std::string& path) {
    if (path.empty()) return {};
    ControlOptions options;
    options.path = path;
    auto made = ControlServer::make(
        loop, options, [this](std::string_view line, const Peer& peer) { return control_line(line, peer); });
    if (!made) return tl::unexpected(Failure{1, made.error()});
    control = std::move(*made);
    return {};
  }

  Made await_signals() {
    const sigset_t signals = service_signals();
    const auto descriptor = std::make_shared<Descriptor>(signalfd(-1, &signals, SFD_NONBLOCK | SFD_CLOEXEC));
    if (descriptor->get() < 0) return tl::unexpected(Failure{1, "signals cannot be received"});
    loop.on_readable(descriptor->get(), [this, descriptor] { signalled(descriptor->get()); });
    return {};
  }

  Made start() {
    constexpr std::int64_t kLongest_ms = 1000;
    const std::int64_t asked_ms = notifier.watchdog_ms() > 0 ? notifier.watchdog_ms() / 4 : kLongest_ms;
    loop.every(LiveTraces::kEvery,
               [this] { http->show_traces(session->traces(), session->file().rig.channels.size()); });
    loop.every(std::chrono::milliseconds(std::clamp<std::int64_t>(asked_ms, 10, kLongest_ms)), [this] { look(); });
    if (auto started = session->start(); !started) return tl::unexpected(Failure{1, started.error()});
    return {};
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
  auto impl = std::make_unique<Impl>(log, drivers, options.start_patience_ns);
  Impl& self = *impl;
  auto made = self.make_rights(file)
                  .and_then([&] { return self.make_session(std::move(file)); })
                  .and_then([&] { return self.make_http(options.page_folder); })
                  .and_then([&] { return self.make_plc(); })
                  .and_then([&] { return self.make_control(options.control_path); })
                  .and_then([&] { return options.handle_signals ? self.await_signals() : Impl::Made(); })
                  .and_then([&] { return self.start(); });
  if (!made) return tl::unexpected(std::move(made.error()));
  return std::unique_ptr<Service>(new Service(std::move(impl)));
}

Service::~Service() = default;

void Service::run() {
  Impl& self = *impl_;
  self.log.info("serving rig \"" + self.session->file().rig.name + "\" on " + self.session->file().server.listen.host +
                " port " + std::to_string(port()));
  self.notifier.ready();
  self.loop.run([&self](const char* failure) { self.log.error(std::string("event loop: ") + failure); });
  self.notifier.stopping();
  self.control.reset();
  self.http.reset();
  self.plc.reset();
  self.session->end();
  self.tell_events();
  // First: a file that is being signed may be large, and systemd waits 15 s.
  if (record::Recorder* const recorder = self.session->recorder()) recorder->finish();
  self.signer.reset();
  self.session.reset();
  self.log.info("stopped");
}

void Service::stop() { impl_->loop.stop(); }

std::uint16_t Service::port() const { return impl_->http->server().port(); }

}  // namespace dwell
