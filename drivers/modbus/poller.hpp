// The polling loop of one device: reads every block on absolute deadlines, pushes what came, tells what did not.
//
// A block that fails now and then costs only its own samples. After three failures in a row (or a second of them) its
// channels are stale, with the reason; unless it is the only block it is then retried ever more seldom, so that a dead
// station does not take the others' time. A lost connection is made anew, after 0.1 s … 5 s, for ever.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/common/backoff.hpp"
#include "drivers/common/delivery.hpp"
#include "drivers/common/failure_run.hpp"
#include "drivers/dwell_driver.hpp"
#include "drivers/modbus/link.hpp"
#include "drivers/modbus/setup.hpp"

namespace dwell::modbus {

// What went wrong in one line for people, for instance "station 3: no answer within 0.1 s".
[[nodiscard]] std::string reason_of(const Answer& answer, const Block& block, const Setup& setup);

class Poller {
 public:
  Poller(Setup setup, const driver::Host& host);
  void run(driver::Stop& stop);

 private:
  struct Polled {
    Block block;
    std::size_t first = 0;  // of its readings, as the delivery counts them
    driver::Backoff backoff;
    driver::FailureRun failures;
    std::int64_t not_before_ns = 0;  // CLOCK_MONOTONIC
  };

  void poll(driver::Stop& stop);
  bool read(Polled& polled, const driver::Stop& stop);
  void deliver(Polled& polled, const Answer& answer) noexcept;
  void note_failure(Polled& polled, const Answer& answer);
  void warn_if_too_fast() const;

  Setup setup_;
  driver::Host host_;
  Link link_;
  driver::Delivery delivery_;
  std::vector<Polled> polled_;
  std::vector<std::uint16_t> registers_;  // one block's registers
  driver::Backoff reconnect_;
  int silences_ = 0;  // requests in a row after which nothing at all came
};

}  // namespace dwell::modbus
