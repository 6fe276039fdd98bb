#include "daemon/ctl/half_written.hpp"

#include <unistd.h>

#include <cstddef>

namespace dwell::ctl {
namespace {

volatile std::sig_atomic_t came = 0;

void note(int signal) { came = signal; }

}  // namespace

HalfWritten::HalfWritten() {
  came = 0;
  struct sigaction noted {};
  noted.sa_handler = note;
  noted.sa_flags = SA_RESTART;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    ::sigaction(kSignals[i], nullptr, &before_[i]);
    if (before_[i].sa_handler != SIG_IGN) ::sigaction(kSignals[i], &noted, nullptr);
  }
}

HalfWritten::~HalfWritten() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before_[i], nullptr);
}

void HalfWritten::check() {
  if (came != 0) throw AskedToEnd{came};
}

void end_by(const AskedToEnd& asked) {
  std::signal(asked.signal, SIG_DFL);
  std::raise(asked.signal);
  _exit(128 + asked.signal);  // the signal is blocked: the code that a shell gives to a program it has ended
}

}  // namespace dwell::ctl
