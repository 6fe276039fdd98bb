#include "daemon/ctl/wakeups.hpp"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>

namespace dwell::ctl {

Wakeups::Wakeups() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGWINCH}) sigaddset(&set, signal);
  pthread_sigmask(SIG_BLOCK, &set, &before_);
  signals_ = ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
  epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
  add(signals_);
}

Wakeups::~Wakeups() {
  (void)take();
  if (epoll_ >= 0) ::close(epoll_);
  if (signals_ >= 0) ::close(signals_);
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void Wakeups::add(int fd) const {
  epoll_event event{};
  event.events = EPOLLIN;
  if (fd >= 0) ::epoll_ctl(epoll_, EPOLL_CTL_ADD, fd, &event);
}

void Wakeups::wait(Deadline deadline) const {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
  pollfd look{epoll_, POLLIN, 0};
  ::poll(&look, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 3'600'000)));
}

Wakeups::Signals Wakeups::take() const {
  Signals signals;
  signalfd_siginfo taken{};
  while (signals_ >= 0 && ::read(signals_, &taken, sizeof taken) > 0) {
    const int number = static_cast<int>(taken.ssi_signo);
    if (number == SIGTSTP) {
      signals.suspend = true;
    } else if (number == SIGWINCH) {
      signals.resized = true;
    } else {
      signals.end = true;
    }
  }
  return signals;
}

}  // namespace dwell::ctl
