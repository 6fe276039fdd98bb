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
#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/backoff.hpp"
#include "drivers/socketcan/bus.hpp"

namespace dwell::can {

class Reader {
 public:
  Reader(Setup setup, const driver::Host& host, socketcan::Open open);
  void run(driver::Stop& stop);

  // The filters that a socket for this setup needs.
  [[nodiscard]] static std::vector<can_filter> filters(const Setup& setup) { return Decoder(setup.wanted).filters(); }

 private:
  struct Target {
    Channel channel;
    dwell_fault told = DWELL_FAULT_SILENT;  // the state the host was told last; it begins with silent
    int failures = 0;                       // frames in a row that held no number
    bool gap = false;                       // something was lost since the last sample
    std::int64_t seen_ns = 0;               // CLOCK_MONOTONIC: when its frame came last
    std::int64_t last_ns = INT64_MIN;       // instant of its last sample
    int source = -1;                        // J1939: the address it came from last
  };

  void open(driver::Stop& stop);
  void read(const driver::Stop& stop);
  void take(const socketcan::Receipt& receipt);
  void deliver(const socketcan::Frame& frame) noexcept;
  void fail(Target& target, Verdict verdict) noexcept;
  void note_controller(const socketcan::Receipt& receipt);
  void tell_controller();
  void note_losses(const socketcan::Receipt& receipt);
  void note_source(Target& target, canid_t id);
  void hold(dwell_fault fault, const std::string& reason);
  void release() noexcept;
  void watch_link();
  void watch_silence(std::int64_t now_ns);
  void tell(Target& target, dwell_fault fault, const char* reason) noexcept;

  Setup setup_;
  driver::Host host_;
  Decoder decoder_;
  socketcan::Bus bus_;
  std::vector<Target> targets_;
  std::vector<dwell_sample> scan_;
  socketcan::Backoff reconnect_;
  bool held_ = false;  // all channels are stale for a reason that is not theirs
  std::string held_reason_;
  bool link_down_ = false;  // … which is that
  std::int64_t now_ns_ = 0;
  std::int64_t next_watch_ns_ = 0;
  std::uint64_t lost_ = 0;  // since the last line about it
  std::int64_t next_loss_line_ns_ = 0;
  socketcan::Controller told_controller_ = socketcan::Controller::active;
  std::int64_t next_controller_line_ns_ = 0;
  bool restarted_ = false;
  bool told_sources_ = false, told_hardware_ = false;
};

}  // namespace dwell::can
