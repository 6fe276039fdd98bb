// What a CAN controller says of itself, for the host: its errors counted, a change of its state as a line of log, at
// most once a second. Bound to one thread.
#pragma once

#include <algorithm>

#include "drivers/common/seldom.hpp"
#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/bus.hpp"

namespace dwell::socketcan {

class ControllerNews {
 public:
  explicit ControllerNews(const driver::Host& host) : host_(host) {}

  // The bus was opened.
  void begin() noexcept { told_ = Controller::active; }
  // After each read of the bus.
  void count(const Receipt& receipt) noexcept {
    const unsigned off = receipt.bus_off ? 1 : 0;
    host_.count(DWELL_FAULT_BUS_OFF, off);
    host_.count(DWELL_FAULT_BUS_ERROR, std::max(receipt.errors, off) - off);
    restarted_ = restarted_ || receipt.restarted;
  }
  // Now and then, so that a line that had to wait is written.
  void log(const Bus& bus, std::int64_t now_ns) {
    const Controller now = bus.controller();
    if ((now == told_ && !restarted_) || !line_.due(now_ns)) return;
    host_.log(now > told_ ? DWELL_WARNING : DWELL_INFO,
              bus.name() + ": the controller " + (restarted_ ? "was restarted, and is " : "is ") + to_string(now));
    told_ = now;
    restarted_ = false;
  }

 private:
  driver::Host host_;
  Controller told_ = Controller::active;
  bool restarted_ = false;
  driver::Seldom line_;
};

}  // namespace dwell::socketcan
