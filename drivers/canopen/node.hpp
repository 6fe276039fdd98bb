// One node from its reset to its samples: commanded (NMT), set up (Configurator over SdoClient), started, and watched
// by its heartbeat. A node that restarts is set up again; one that is silent, or is not what the rig file says, is
// tried again after 0.1 s … 5 s, for ever, and says why it does not deliver. Its emergencies become lines of log.
//
// A pure state machine on frames and time (CLOCK_MONOTONIC); what it sends goes into an outbox. Bound to one thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/canopen/configurator.hpp"
#include "drivers/canopen/outbox.hpp"
#include "drivers/canopen/sdo_client.hpp"
#include "drivers/common/backoff.hpp"
#include "drivers/common/seldom.hpp"
#include "drivers/dwell_driver.hpp"

namespace dwell::canopen {

class Node {
 public:
  Node(const Wish& wish, const driver::Host& host, Outbox& outbox);

  // From the beginning: resets its communication and sets it up.
  void reset(std::int64_t now_ns);
  // Nothing is expected of it, nor sent to it, until reset.
  void rest() noexcept;

  // A frame of one of its identifiers; its PDOs are the caller's.
  void take(const can_frame& frame, std::int64_t now_ns);
  void tick(std::int64_t now_ns);
  // A PDO of it came: it lives.
  void heard(std::int64_t now_ns) noexcept { life_ns_ = now_ns; }
  // One of its PDOs answers SYNC; with `all`, none of them is silent, and the next fault is a first one again.
  void answers(bool all) noexcept;
  // It does not do what it was started for: is set up again.
  void fail(dwell_fault fault, const std::string& what, std::int64_t now_ns);

  [[nodiscard]] bool operational() const noexcept { return phase_ == Phase::operational; }
  // Counts how often it became operational; its PDOs are as of then.
  [[nodiscard]] unsigned starts() const noexcept { return starts_; }
  [[nodiscard]] std::int64_t started_ns() const noexcept { return started_ns_; }
  [[nodiscard]] const std::vector<Pdo>& pdos() const noexcept { return configurator_.pdos(); }
  // Why it does not deliver; none: it does, or nothing is known yet.
  [[nodiscard]] dwell_fault fault() const noexcept { return fault_; }
  [[nodiscard]] const std::string& reason() const noexcept { return reason_; }
  [[nodiscard]] std::string name() const { return configurator_.name(); }

 private:
  enum class Phase : std::uint8_t { resting, booting, configuring, operational, failed };

  void configure(std::int64_t now_ns);
  void go_on(std::int64_t now_ns);
  void start(std::int64_t now_ns);
  void set_fault(dwell_fault fault, const std::string& reason);
  void warn(std::int64_t now_ns);
  void take_state(std::uint8_t state, std::int64_t now_ns);
  void take_emergency(const can_frame& frame, std::int64_t now_ns);
  void flush();

  std::uint8_t id_;
  driver::Host host_;
  Outbox& outbox_;
  Configurator configurator_;
  SdoClient sdo_;
  Phase phase_ = Phase::resting;
  driver::Backoff backoff_;
  dwell_fault fault_ = DWELL_FAULT_NONE;
  std::string reason_;
  unsigned starts_ = 0;
  std::int64_t deadline_ns_ = 0;  // booting: the last instant to boot; failed: of the next attempt
  std::int64_t started_ns_ = 0, failed_ns_ = 0;
  std::int64_t life_ns_ = 0;  // of its last sign of life
  driver::Seldom start_line_, state_line_, emergency_line_;
  unsigned unsaid_ = 0;  // emergencies since the last line
};

}  // namespace dwell::canopen
