// watch: the current dwell, refreshed as the service pushes it, until the operator ends it.
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/dwell_follower.hpp"
#include "daemon/ctl/fetch.hpp"
#include "daemon/ctl/http_client.hpp"
#include "daemon/ctl/json_member.hpp"
#include "daemon/ctl/tables.hpp"
#include "daemon/ctl/terminal.hpp"
#include "daemon/ctl/truth.hpp"
#include "daemon/ctl/wakeups.hpp"
#include "daemon/ctl/watch_page.hpp"
#include "daemon/ctl/watch_questions.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/motion_report.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

using SteadyClock = std::chrono::steady_clock;
using Milliseconds = std::chrono::milliseconds;

constexpr Milliseconds kQuestionTime{1000};   // for an answer to a question beside the stream: keys wait as long
constexpr double kMessage_s = 6.0;            // for reading what came of a key
constexpr Milliseconds kReconnectTime{2000};  // for the service to take a connection again: keys wait as long

Milliseconds from_seconds(double seconds) { return Milliseconds(static_cast<std::int64_t>(1e3 * seconds)); }

double now_s() { return std::chrono::duration<double>(SteadyClock::now().time_since_epoch()).count(); }

std::string time_of_day() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%H:%M:%S", &local);
  return text.data();
}

int complain(int code, const std::string& why) {
  std::fprintf(stderr, "dwellctl: %s\n", printable(why).c_str());
  return code;
}

// Whether there are other coefficients from the transient than before: few times in a dwell.
bool estimated_anew(const DwellView& before, const DwellView& now) {
  if (!now.transient || std::isfinite(now.dwell.settled_s)) return false;
  const MotionEstimate& m = now.transient->estimate;
  if (!before.transient || before.transient->estimate.reason != m.reason) return true;
  return m.reason.empty() && before.transient->estimate.end_s != m.end_s;
}

// The control socket belongs to the service on this computer: watching another one, the key would rearm the wrong rig.
bool on_this_computer(const Url& url) {
  return url.host == "localhost" || url.host == "::1" || url.host.compare(0, 4, "127.") == 0;
}

// The service's answer as JSON; nullopt: none came in time, or it was refused.
Asks asks_at(const Url& url) {
  return [url](const std::string& path) -> std::optional<Json> {
    HttpLimits limits;
    limits.time = kQuestionTime;
    const auto answer = http_get(url, path, limits);
    if (!answer) return std::nullopt;
    return Json::parse(answer->body, nullptr, false);
  };
}

class Watch {
 public:
  Watch(const Service& service, const WatchOptions& options, Url url, std::optional<Truth> truth)
      : service_(service),
        options_(options),
        url_(std::move(url)),
        truth_(std::move(truth)),
        questions_(asks_at(url_), now_s) {
    const bool terminal = !service.json && Terminal::there();
    interval_ = from_seconds(options.interval_s > 0.0 ? options.interval_s : terminal ? 0.1 : 1.0);
    if (options.limit_s > 0.0) give_up_ = in(from_seconds(options.limit_s));
    controls_.may_rearm = on_this_computer(url_);
    state_.name = url_.text;
  }

  int run() {
    const int code = follow();
    if (terminal_) {
      terminal_.reset();  // what is said from here on belongs on the operator's own screen
      std::fputs(last_words(state_, truth(), now_s()).c_str(), stdout);
    }
    if (code == kDone && agreed_) {
      std::fputs("every coefficient lies within 4 standard uncertainties of its true value\n", stdout);
    }
    return why_.empty() ? code : complain(code, why_);
  }

 private:
  [[nodiscard]] const Truth* truth() const { return truth_ ? &*truth_ : nullptr; }

  int follow() {
    while (true) {
      HttpLimits limits;
      if (connected_) limits.time = kReconnectTime;
      auto stream = EventStream::open(url_, "/api/v1/stream", limits);
      if (!stream) {
        if (!connected_) {
          why_ = stream.error();
          return kUnreachable;
        }
        state_.trouble = "trying again, " + stream.error();
      } else {
        begin();
        if (const auto code = read(*stream)) return *code;
      }
      show(true);
      if (const auto code = pause()) return *code;
    }
  }

  // The stream is there. Only now is the terminal taken: an address that does not answer is said on the operator's own
  // screen.
  void begin() {
    back_ = connected_;
    connected_ = true;
    state_.trouble.clear();
    questions_.stream_began();
    if (!wakeups_) wakeups_.emplace();
    if (service_.json || terminal_ || !Terminal::there()) return;
    terminal_.emplace();
    wakeups_->add(terminal_->keys_fd());
    controls_.keys = terminal_->keys_fd() >= 0;
  }

  // Until the stream ends; an exit code: the whole command does.
  std::optional<int> read(EventStream& stream) {
    EventStream::Event event;
    while (true) {
      ask();
      const Deadline tick = in(Milliseconds(1000));
      const auto next = stream.next(event, give_up_ ? std::min(tick, *give_up_) : tick, wakeups_->fd());
      if (!next) {
        state_.trouble = "the stream was lost: " + next.error();
        return std::nullopt;
      }
      switch (*next) {
        case EventStream::Next::stopped:
          if (obey()) return kDone;
          break;
        case EventStream::Next::ended:
          state_.trouble = "the service closed the stream, connecting again";
          return std::nullopt;
        case EventStream::Next::timeout:
          show(true);
          break;
        case EventStream::Next::event:
          if (const auto whole = follower_.take(event)) {
            if (const auto code = take(*whole)) return *code;
          }
          break;
      }
      if (give_up_ && SteadyClock::now() >= *give_up_) {
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
    const auto& before = state_.dwell();
    const bool changed = !before || before->dwell.state != view->dwell.state ||
                         before->dwell.index != view->dwell.index || estimated_anew(*before, *view);
    if (changed) questions_.state_changed();
    state_.take(std::move(*view), now_s());
    const Dwell& dwell = state_.dwell()->dwell;
    const auto& age = state_.dwell()->age;
    const bool enough =
        options_.until_s > 0.0 && std::isfinite(dwell.settled_s) && dwell.end_s - dwell.settled_s >= options_.until_s;
    if (service_.json) {
      std::printf("%s\n", data.c_str());
      std::fflush(stdout);
    } else {
      show(changed || enough);
    }
    if (!enough) return std::nullopt;
    if (age && age->stale) {
      why_ = "the data are there, but stale, from " + age_text(age->s) + " ago" +
             (dwell.doubts.empty() ? "" : ": " + dwell.doubts.front().what);
      return kNo;
    }
    agreed_ = truth_ && agrees(dwell, *truth_, 4.0, why_);
    return !truth_ || agreed_ ? kDone : kNo;
  }

  // For the screen: what the stream does not tell.
  void ask() {
    if (terminal_) questions_.turn(state_);
  }

  // Signals and keys. true: the operator ends it.
  bool obey() {
    const Wakeups::Signals signals = wakeups_->take();
    if (signals.end) return true;
    if (signals.suspend) {
      if (terminal_) terminal_->leave();
      ::kill(::getpid(), SIGSTOP);  // SIGTSTP itself is blocked
      if (terminal_) terminal_->enter();
    }
    if (terminal_) {
      for (const Key key : terminal_->keys())
        if (press(key)) return true;
      show(true);
    }
    return false;
  }

  bool press(Key key) {
    controls_.message.clear();
    pressed_s_ = now_s();
    if (!controls_.question.empty()) {
      controls_.question.clear();
      if (key == Key::yes) {
        const auto answer = ask_to_rearm(service_.control, kReconnectTime);
        controls_.message = answer ? "rearmed at " + time_of_day() : "not rearmed: " + answer.error().why;
      } else {
        controls_.message = "not rearmed";
      }
      return false;
    }
    switch (key) {
      case Key::quit:
        return true;
      case Key::pause:
        if (controls_.paused_s) {
          controls_.paused_s.reset();
          frozen_.reset();
        } else {
          controls_.paused_s = now_s();
          frozen_ = state_;
        }
        break;
      case Key::next:
        controls_.page = std::min(controls_.page + 1, page_.pages - 1);
        break;
      case Key::back:
        // Beyond the last page stands the last one.
        controls_.page = std::max<std::size_t>(std::min(controls_.page, page_.pages - 1), 1) - 1;
        break;
      case Key::rearm:
        if (controls_.may_rearm) controls_.question = "rearm: end this dwell here and settle anew?";
        break;
      case Key::yes:
      case Key::other:
        break;
    }
    return false;
  }

  void show(bool at_once) {
    if (service_.json || (!at_once && SteadyClock::now() - shown_ < interval_)) return;
    shown_ = SteadyClock::now();
    if (terminal_) {
      if (now_s() - pressed_s_ > kMessage_s) controls_.message.clear();
      page_ = draw(frozen_ ? *frozen_ : state_, controls_, truth(), Terminal::size(), now_s(), time_of_day());
      terminal_->show(page_.lines);
    } else {
      append();
    }
  }

  // Where there is no terminal: one text below the other. Numbers that are no longer renewed are not said again; those
  // of a dwell that has ended are said once.
  void append() {
    const bool fresh = state_.dwell() && !state_.old(now_s());
    std::string status = url_.text;
    if (!state_.trouble.empty()) {
      status += " · " + printable(state_.trouble);
    } else if (state_.dwell() && !fresh) {
      status +=
          state_.silence(now_s()) == Silence::estimation ? " · the estimation publishes nothing new" : " · no new data";
    } else if (state_.ended()) {
      status += " · not of now, ended: " + printable(why_ended(state_.dwell()->dwell));
    } else if (back_) {
      status += " · connected again";
    }
    if ((!fresh || state_.ended()) && status == said_) return;
    std::printf("%s\n%s\n", status.c_str(), fresh ? dwell_text(*state_.dwell(), truth()).c_str() : "");
    std::fflush(stdout);
    said_ = status;
    if (fresh) back_ = false;
  }

  // A second before connecting again.
  std::optional<int> pause() {
    const Deadline until = in(Milliseconds(1000));
    while (SteadyClock::now() < until) {
      wakeups_->wait(give_up_ ? std::min(until, *give_up_) : until);
      if (obey()) return kDone;
      if (give_up_ && SteadyClock::now() >= *give_up_) {
        why_ = "the service did not come back within the time allowed";
        return kNo;
      }
    }
    return std::nullopt;
  }

  const Service& service_;
  const WatchOptions& options_;
  const Url url_;
  const std::optional<Truth> truth_;
  std::optional<Wakeups> wakeups_;    // once connected
  std::optional<Terminal> terminal_;  // where there is one
  Milliseconds interval_{};
  std::optional<Deadline> give_up_;
  Questions questions_;
  DwellFollower follower_;
  WatchState state_;
  std::optional<WatchState> frozen_;  // as it was when the operator paused
  Controls controls_;
  double pressed_s_ = kNever;  // when the last key was pressed
  Page page_;                  // as last shown
  SteadyClock::time_point shown_;
  bool connected_ = false;
  bool back_ = false;    // connected again, and not yet said
  std::string said_;     // the status line as last appended
  bool agreed_ = false;  // with the truth
  std::string why_;      // what to say on standard error at the end
};

}  // namespace

int watch(const Service& service, const WatchOptions& options) {
  auto url = url_of(service);
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
