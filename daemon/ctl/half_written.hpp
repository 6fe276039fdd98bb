// SIGINT and SIGTERM while a file is written: the work ends where it can, and nothing half written stays.
#pragma once

namespace dwell::ctl {

// Thrown where the program was asked to end.
struct AskedToEnd {
  int signal;
};

// While it exists, these two signals end nothing by themselves. One at a time in a program; one thread.
class HalfWritten {
 public:
  HalfWritten();
  ~HalfWritten();
  HalfWritten(const HalfWritten&) = delete;
  HalfWritten& operator=(const HalfWritten&) = delete;

  // Throws AskedToEnd if one has come. Call it some times a second.
  static void check();
};

// Ends the program as the signal would have ended it.
void end_by(const AskedToEnd& asked);

}  // namespace dwell::ctl
