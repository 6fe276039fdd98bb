// SIGINT, SIGTERM and SIGHUP while a file is written: the work ends where it can, and nothing half written stays.
#pragma once

#include <array>
#include <csignal>

namespace dwell::ctl {

// Thrown where the program was asked to end.
struct AskedToEnd {
  int signal;
};

// While it exists, these signals only set a flag. A signal that is ignored stays so. One at a time in a program; one
// thread.
class HalfWritten {
 public:
  HalfWritten();
  ~HalfWritten();  // what the signals did before
  HalfWritten(const HalfWritten&) = delete;
  HalfWritten& operator=(const HalfWritten&) = delete;

  // Throws AskedToEnd if one has come. Call it some times a second, and at the end of the work.
  static void check();

 private:
  static constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, kSignals.size()> before_{};
};

// Ends the program as the signal would have ended it.
[[noreturn]] void end_by(const AskedToEnd& asked);

}  // namespace dwell::ctl
