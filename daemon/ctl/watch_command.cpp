// watch: the current dwell, refreshed as the service pushes it, until Ctrl-C.
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/http_client.hpp"
#include "daemon/ctl/screen.hpp"
#include "daemon/ctl/truth.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::milliseconds;

Milliseconds from_seconds(double seconds) { return Milliseconds(static_cast<std::int64_t>(1e3 * seconds)); }

// Readable once somebody wants the command to end; the signals do nothing else while this lives.
class StopSignals {
 public:
  StopSignals() {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
    pthread_sigmask(SIG_BLOCK, &set, &before_);
    fd_ = ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
  }
  ~StopSignals() {
    signalfd_siginfo taken{};
    while (fd_ >= 0 && ::read(fd_, &taken, sizeof taken) > 0) {
    }
    if (fd_ >= 0) ::close(fd_);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  [[nodiscard]] int fd() const noexcept { return fd_; }

 private:
  sigset_t before_{};
  int fd_ = -1;
};

int complain(int code, const std::string& why) {
  std::fprintf(stderr, "dwellctl: %s\n", printable(why).c_str());
  return code;
}

class Watch {
 public:
  Watch(const Service& service, const WatchOptions& options, Url url, std::optional<Truth> truth)
      : service_(service), options_(options), url_(std::move(url)), truth_(std::move(truth)) {
    if (!service_.json) screen_.emplace();
    interval_ = from_seconds(options.interval_s > 0.0         ? options.interval_s
                             : screen_ && screen_->in_place() ? 0.1
                                                              : 1.0);
    if (options.limit_s > 0.0) give_up_ = in(from_seconds(options.limit_s));
  }

  int run() {
    const int code = follow();
    screen_.reset();  // what is said from here on belongs on the operator's own screen
    if (code == kDone && agreed_) {
      std::fputs("every coefficient lies within 4 standard uncertainties of its true value\n", stdout);
    }
    return why_.empty() ? code : complain(code, why_);
  }

 private:
  int follow() {
    while (true) {
      auto stream = EventStream::open(url_, "/api/v1/stream");
      if (!stream) {
        if (!connected_) {
          why_ = stream.error();
          return kUnreachable;
        }
        lost_ = "not reachable, trying again: " + stream.error();
      } else {
        lost_ = connected_ ? "connected again" : "";
        connected_ = true;
        if (const auto code = read(*stream)) return *code;
      }
      show(true);
      if (const auto code = pause()) return *code;
    }
  }

  // Until the stream ends; an exit code: the whole command does.
  std::optional<int> read(EventStream& stream) {
    EventStream::Event event;
    while (true) {
      const Deadline tick = in(Milliseconds(1000));
      const auto next = stream.next(event, give_up_ ? std::min(tick, *give_up_) : tick, stop_.fd());
      if (!next) {
        lost_ = "the stream was lost: " + next.error();
        return std::nullopt;
      }
      switch (*next) {
        case EventStream::Next::stopped:
          return kDone;
        case EventStream::Next::ended:
          lost_ = "the service closed the stream, connecting again";
          return std::nullopt;
        case EventStream::Next::timeout:
          show(true);
          break;
        case EventStream::Next::event:
          if (event.name == "dwell") {
            if (const auto code = take(event.data)) return *code;
          }
          break;
      }
      if (give_up_ && Clock::now() >= *give_up_) {
        why_ = "not enough data within the time allowed";
        return kNo;
      }
    }
  }

  std::optional<int> take(const std::string& data) {
    auto view = parse_dwell(data);
    if (!view) {
      why_ = service_.url + ": what answers is not the service: " + view.error();
      return kUnreachable;
    }
    const bool changed = !view_ || view_->dwell.state != view->dwell.state || view_->dwell.index != view->dwell.index;
    view_ = std::move(*view);
    heard_ = Clock::now();
    if (lost_ == "connected again" && !changed) lost_.clear();
    const Dwell& dwell = view_->dwell;
    const bool enough =
        options_.until_s > 0.0 && std::isfinite(dwell.settled_s) && dwell.end_s - dwell.settled_s >= options_.until_s;
    if (service_.json) {
      std::printf("%s\n", data.c_str());
      std::fflush(stdout);
    } else {
      show(changed || enough);
    }
    if (!enough) return std::nullopt;
    agreed_ = truth_ && agrees(dwell, *truth_, 4.0, why_);
    return !truth_ || agreed_ ? kDone : kNo;
  }

  void show(bool at_once) {
    if (!screen_ || (!at_once && Clock::now() - shown_ < interval_)) return;
    const double silent_s = std::chrono::duration<double>(Clock::now() - heard_).count();
    const bool quiet = view_ && silent_s > 2.0;
    std::string status = url_.text;
    if (!lost_.empty()) status += " · " + printable(lost_);
    if (quiet) status += " · no news for " + seconds_text(silent_s, 0);
    if (!screen_->in_place() && status == status_ && quiet) return;  // nothing new to append
    status_ = status;
    shown_ = Clock::now();
    screen_->show(status, view_ ? dwell_text(*view_, truth_ ? &*truth_ : nullptr) : "");
  }

  // A second before connecting again.
  std::optional<int> pause() {
    const Deadline until = in(Milliseconds(1000));
    while (Clock::now() < until) {
      signalfd_siginfo taken{};
      if (::read(stop_.fd(), &taken, sizeof taken) > 0) return kDone;
      if (give_up_ && Clock::now() >= *give_up_) {
        why_ = "the service did not come back within the time allowed";
        return kNo;
      }
      ::usleep(20'000);
    }
    return std::nullopt;
  }

  const Service& service_;
  const WatchOptions& options_;
  const Url url_;
  const std::optional<Truth> truth_;
  StopSignals stop_;
  std::optional<Screen> screen_;  // none with --json
  Milliseconds interval_{};
  std::optional<Deadline> give_up_;
  bool connected_ = false;
  bool agreed_ = false;  // with the truth
  std::optional<DwellView> view_;
  Clock::time_point heard_;
  Clock::time_point shown_;
  std::string lost_;    // what is wrong with the connection
  std::string status_;  // as last shown
  std::string why_;     // what to say on standard error at the end
};

}  // namespace

int watch(const Service& service, const WatchOptions& options) {
  auto url = parse_url(service.url);
  if (!url) return complain(kUsage, url.error());
  std::optional<Truth> truth;
  if (!options.truth.empty()) {
    auto read = read_truth(options.truth);
    if (!read) return complain(kUsage, read.error());
    truth = std::move(*read);
  }
  return Watch(service, options, std::move(*url), std::move(truth)).run();
}

}  // namespace dwell::ctl
