// The polling loop of one device: reads every block on absolute deadlines, pushes what came, tells what did not.
//
// A block that fails now and then costs only its own samples. After three failures in a row (or a second of them) its
// channels are stale, with the reason; unless it is the only block it is then retried ever more seldom, so that a dead
// station does not take the others' time. A lost connection is made anew, after 0.1 s … 5 s, for ever.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/dwell_driver.hpp"
#include "drivers/modbus/link.hpp"
#include "drivers/modbus/setup.hpp"

namespace dwell::modbus {

// Doubling waits, from 0.1 s to a longest one.
class Backoff {
 public:
  explicit Backoff(std::int64_t longest_ns) : longest_ns_(longest_ns) {}
  [[nodiscard]] std::int64_t next_ns() noexcept {
    const std::int64_t wait_ns = next_ns_;
    next_ns_ = std::min(2 * next_ns_, longest_ns_);
    return wait_ns;
  }
  void reset() noexcept { next_ns_ = kShortest_ns; }

 private:
  static constexpr std::int64_t kShortest_ns = 100'000'000;
  std::int64_t longest_ns_;
  std::int64_t next_ns_ = kShortest_ns;
};

// What went wrong in one line for people, for instance "station 3: no answer within 0.1 s".
[[nodiscard]] std::string reason_of(const Answer& answer, const Block& block, const Setup& setup);

class Poller {
 public:
  Poller(Setup setup, const driver::Host& host);
  void run(driver::Stop& stop);

 private:
  struct Target {
    Reading reading;
    dwell_fault told = DWELL_FAULT_SILENT;  // the state the host was told last; it begins with silent
    int invalid = 0;                        // values in a row that were not numbers
  };
  struct Polled {
    Block block;
    std::vector<Target> targets;
    Backoff backoff;
    int failures = 0;                // in a row
    std::int64_t failing_ns = 0;     // since when
    std::int64_t not_before_ns = 0;  // CLOCK_MONOTONIC
  };

  void poll(driver::Stop& stop);
  bool read(Polled& polled, const driver::Stop& stop);
  void deliver(Polled& polled, const Answer& answer) noexcept;
  void note_failure(Polled& polled, const Answer& answer);
  void disconnected(const std::string& reason);
  void tell(Target& target, dwell_fault fault, const char* reason) noexcept;
  void warn_if_too_fast() const;

  Setup setup_;
  driver::Host host_;
  Link link_;
  std::vector<Polled> polled_;
  std::vector<dwell_sample> scan_;        // one block's readings
  std::vector<std::uint16_t> registers_;  // one block's registers
  Backoff reconnect_;
  int silences_ = 0;  // requests in a row after which nothing at all came
};

}  // namespace dwell::modbus
