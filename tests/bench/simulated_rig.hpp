// rigsim in a process of its own, so that what it costs is not counted as ours. Ends with this object, or with the
// thread that made it.
#pragma once

#include <sys/types.h>

#include <string>

namespace dwell {

class SimulatedRig {
 public:
  // program: rigsim's path. Returns when the rig serves, or has failed to.
  explicit SimulatedRig(const std::string& program);
  ~SimulatedRig();
  SimulatedRig(const SimulatedRig&) = delete;
  SimulatedRig& operator=(const SimulatedRig&) = delete;

  // Of its Modbus TCP server at 127.0.0.1; 0: there is none.
  [[nodiscard]] int port() const noexcept { return port_; }

 private:
  pid_t process_ = -1;
  int port_ = 0;
};

}  // namespace dwell
