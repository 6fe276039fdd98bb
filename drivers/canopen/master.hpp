// The thread of one CANopen bus: takes its frames, gives the network its time, sends what it wants sent, and SYNC when
// it is due. An interface that is gone is opened anew, after 0.1 s … 5 s, for ever; after that, after a link that was
// down and a controller that was off the bus every node is set up again.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/canopen/network.hpp"
#include "drivers/canopen/setup.hpp"
#include "drivers/common/backoff.hpp"
#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/bus.hpp"
#include "drivers/socketcan/controller_news.hpp"

namespace dwell::canopen {

class Master {
 public:
  Master(const Setup& setup, const driver::Host& host, socketcan::Open open);
  void run(driver::Stop& stop);

 private:
  void open(driver::Stop& stop);
  void read(const driver::Stop& stop);
  void take(const socketcan::Receipt& receipt, std::int64_t now_ns);
  void watch_link(std::int64_t now_ns);
  void disconnected(const std::string& reason);
  void break_off(int error);
  bool send_pending();
  void send_sync(std::int64_t now_ns);

  driver::Host host_;
  socketcan::Bus bus_;
  Network network_;
  socketcan::ControllerNews controller_;
  driver::Backoff reconnect_;
  std::int64_t next_try_ns_ = 0;  // to open, or to set the nodes up again after the link was down
  std::int64_t next_link_ns_ = 0;
  socketcan::Link link_ = socketcan::Link::up;  // as seen last
  std::uint64_t dropped_ = 0;                   // of what was to be sent, counted so far
};

}  // namespace dwell::canopen
