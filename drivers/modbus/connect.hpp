// TCP connections that never make stop wait: neither for a name server nor for a device that is off.
#pragma once

#include <memory>
#include <string>

#include "drivers/dwell_driver.hpp"

namespace dwell::modbus {

class Connector {
 public:
  Connector(std::string host, int port);
  ~Connector();
  Connector(const Connector&) = delete;
  Connector& operator=(const Connector&) = delete;

  // A connected, non-blocking descriptor below 1024, which the caller closes; -1: `error` says why.
  int connect(std::int64_t deadline_ns, const driver::Stop& stop, std::string& error);

 private:
  struct Lookup;
  std::string host_;
  std::string port_;
  std::shared_ptr<Lookup> lookup_;  // one under way; a name server that hangs is not asked twice
};

}  // namespace dwell::modbus
