#include "daemon/ctl/half_written.hpp"

#include <csignal>

namespace dwell::ctl {
namespace {

volatile std::sig_atomic_t came = 0;

void note(int signal) { came = signal; }

void handle(void (*how)(int)) {
  struct sigaction action {};
  action.sa_handler = how;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction now {};
    // Whoever starts a program with a signal ignored wants it ignored.
    if (::sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);
  }
}

}  // namespace

HalfWritten::HalfWritten() {
  came = 0;
  handle(note);
}

HalfWritten::~HalfWritten() { handle(SIG_DFL); }

void HalfWritten::check() {
  if (came != 0) throw AskedToEnd{came};
}

void end_by(const AskedToEnd& asked) {
  std::signal(asked.signal, SIG_DFL);
  std::raise(asked.signal);
}

}  // namespace dwell::ctl
