// What may interrupt a command that waits for the service: the signals that end it, stop it for a while or say that the
// terminal has another size, and a descriptor for keys; all of them behind one descriptor.
//
// The signals do nothing else while this lives. Bound to one thread; one at a time.
#pragma once

#include <signal.h>

#include "daemon/ctl/stream_socket.hpp"

namespace dwell::ctl {

class Wakeups {
 public:
  Wakeups();
  ~Wakeups();
  Wakeups(const Wakeups&) = delete;
  Wakeups& operator=(const Wakeups&) = delete;

  // Readable once a signal has come or `fd` is readable. A negative fd is ignored.
  void add(int fd) const;
  [[nodiscard]] int fd() const noexcept { return epoll_; }
  // Waits for that, at most until the deadline.
  void wait(Deadline deadline) const;

  struct Signals {
    bool end = false;      // SIGINT, SIGTERM, SIGHUP, SIGQUIT
    bool suspend = false;  // SIGTSTP
    bool resized = false;  // SIGWINCH
  };
  // Those that have come since the last call; does not wait.
  [[nodiscard]] Signals take() const;

 private:
  sigset_t before_{};
  int signals_ = -1;
  int epoll_ = -1;
};

}  // namespace dwell::ctl
