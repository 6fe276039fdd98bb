// A serial port of our own: two programs that poll one line take each other's answers, and RTU cannot tell them apart.
//
// flock keeps programs away that ask for the lock, as this plugin does in the service and in `dwellctl check`; TIOCEXCL
// all others, except those of the superuser. Bound to one thread.
#pragma once

#include <string>

namespace dwell::modbus {

class SerialLock {
 public:
  SerialLock() = default;
  ~SerialLock() { release(); }
  SerialLock(const SerialLock&) = delete;
  SerialLock& operator=(const SerialLock&) = delete;

  // Before the port is opened to be used. Empty: it is ours, else why not. Does not wait.
  [[nodiscard]] std::string take(const std::string& port);
  // Once it is open: nobody else may open it.
  void exclude_others() noexcept;
  void release() noexcept;

 private:
  int descriptor_ = -1;
};

}  // namespace dwell::modbus
