// Reads one bus and pushes what its frames hold: one frame, one scan.
//
// A channel whose frame stays away is stale, with the reason; so are all when the link is down, the interface gone or
// the controller off the bus. Each comes back by itself with its next frame. An interface that is gone is opened anew,
// after 0.1 s … 5 s, for ever.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/can/setup.hpp"
#include "drivers/common/backoff.hpp"
#include "drivers/common/delivery.hpp"
#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/bus.hpp"
#include "drivers/socketcan/controller_news.hpp"

namespace dwell::can {

class Reader {
 public:
  Reader(Setup setup, const driver::Host& host, socketcan::Open open);
  void run(driver::Stop& stop);

  // The filters that a socket for this setup needs.
  [[nodiscard]] static std::vector<can_filter> filters(const Setup& setup) { return Decoder(setup.wanted).filters(); }

 private:
  struct Heard {
    std::int64_t seen_ns = 0;  // CLOCK_MONOTONIC: when its frame came last
    int source = -1;           // J1939: the address it came from last
  };

  void open(driver::Stop& stop);
  void read(const driver::Stop& stop);
  void take(const socketcan::Receipt& receipt);
  void deliver(const socketcan::Frame& frame) noexcept;
  void fail(std::size_t channel, Verdict verdict) noexcept;
  void note_source(std::size_t channel, canid_t id);
  void disconnected(const std::string& reason);
  void release() noexcept;
  void watch_link();
  void watch_silence();

  Setup setup_;
  driver::Host host_;
  Decoder decoder_;
  socketcan::Bus bus_;
  socketcan::ControllerNews controller_;
  driver::Delivery delivery_;
  std::vector<Heard> heard_;  // of each channel
  driver::Backoff reconnect_;
  bool link_down_ = false;  // that holds the channels
  std::int64_t now_ns_ = 0;
  std::int64_t next_watch_ns_ = 0;
  bool told_sources_ = false, told_hardware_ = false;
};

}  // namespace dwell::can
