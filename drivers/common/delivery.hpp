// The channels of one device on their way to the host: what every driver does with readings and with failures.
//
//   delivery.add(channel, {t_ns, t_half_ns}, raw); … delivery.push();          readings that belong together
//   delivery.fail(channel, DWELL_FAULT_INVALID_VALUE, now_ns, [] { … });       a reading without a value
//   delivery.tell(channel, DWELL_FAULT_TIMEOUT, "no answer within 0.1 s");     the channel does not deliver
//   delivery.hold(DWELL_FAULT_DISCONNECTED, "can0: the link is down");         none of them does
//
// - States are told when they change, by fault or by reason, and never twice. A channel begins silent; its next reading
//   ends whatever was told of it.
// - A channel whose readings have no value is stale once these are a FailureRun.
// - What is lost, fails or is stale after a channel's first reading marks the gap on its next one.
// - Stamps advance in every channel: one that does not is set to 1 ns after the one before, and flagged.
//
// Channels count by their place in the list that the object is made from. Bound to one thread. add, lost and push are
// real-time safe; what changes a state may allocate.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/common/failure_run.hpp"
#include "drivers/common/seldom.hpp"
#include "drivers/dwell_driver.hpp"

namespace dwell::driver {

// When a reading was taken, in CLOCK_MONOTONIC_RAW.
struct Instant {
  std::int64_t t_ns = 0;
  std::uint32_t t_half_ns = 0;
  bool replaced = false;  // the device's own stamp was of no use
};

class Delivery {
 public:
  // `channels`: whatever has dwell_channel's `index`.
  template <class Channels>
  Delivery(const Host& host, const Channels& channels) : host_(host) {
    for (const auto& channel : channels) channels_.push_back({channel.index});
    scan_.reserve(channels_.size());
  }

  // One reading of the scan; `raw` is finite.
  void add(std::size_t channel, const Instant& instant, double raw) noexcept;
  // Readings in the scan.
  [[nodiscard]] std::size_t size() const noexcept { return scan_.size(); }
  // Hands in the scan and begins the next one. false: there was no reading in it. A refused scan is lost.
  bool push() noexcept;

  // A reading was lost; without a channel: of any of them, nobody can say which.
  void lost(std::size_t channel) noexcept;
  void lost() noexcept;
  // So many of `who`'s frames were lost for lack of room: counted, a gap in every channel, a line of log a second.
  void overflow(std::uint64_t frames, const std::string& who, std::int64_t now_ns);
  // A reading came and holds no value: counted. `reason()` is asked for when the channel becomes stale by it.
  template <class Reason>
  void fail(std::size_t channel, dwell_fault fault, std::int64_t now_ns, const Reason& reason) {
    host_.count(fault);
    lost(channel);
    if (channels_[channel].failures.add(now_ns) && told(channel) != fault) tell(channel, fault, reason());
  }

  // The channel does not deliver, for this reason.
  void tell(std::size_t channel, dwell_fault fault, std::string_view reason);
  [[nodiscard]] dwell_fault told(std::size_t channel) const noexcept { return channels_[channel].told; }

  // What all channels depend on is not there; so it begins. After release each has its own time anew to deliver.
  void hold(dwell_fault fault, std::string_view reason);
  void release() noexcept { held_ = false; }
  [[nodiscard]] bool held() const noexcept { return held_; }

 private:
  struct Channel {
    std::uint16_t index = 0;
    dwell_fault told = DWELL_FAULT_SILENT;
    std::string reason = {};
    FailureRun failures = {};  // readings without a value
    bool gap = false;
    std::int64_t last_ns = INT64_MIN;  // of its last reading
  };

  Host host_;
  std::vector<Channel> channels_;
  std::vector<dwell_sample> scan_;
  bool held_ = true;
  std::uint64_t overflow_ = 0;  // frames since the last line about them
  Seldom overflow_line_;
};

}  // namespace dwell::driver
