// Whether a channel delivers, why not, and how fast: what its driver says, what its silence says, told apart by the
// instants at which it was said. Virtual time; bound to the estimation thread. No allocation per sample.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "core/stream/record.hpp"

namespace dwell {

class ChannelWatch {
 public:
  // nominal_rate_hz: 0 where not known. A channel that says nothing for 20 nominal intervals, at least 1 s, is silent.
  ChannelWatch(double nominal_rate_hz, std::int64_t now_ns);

  // A sample, stamped t_ns, taken in at now_ns. true: the channel was stale and delivers again, for a sample is proof
  // of it; not if the sample is older than the fault.
  bool sample(std::int64_t t_ns, std::int64_t now_ns) noexcept;

  // Something came of it, whatever it was worth.
  void heard(std::int64_t now_ns) noexcept {
    heard_ns_ = now_ns;
    ++samples_;
  }

  // The driver says how it stands. true: this is new.
  bool said(std::int64_t t_ns, Fault fault, const char* reason);

  // true: the channel has just fallen silent.
  bool fell_silent(std::int64_t now_ns);

  // Brings rate_hz up to date; call a few times a second.
  void measure_rate(std::int64_t now_ns) noexcept;

  [[nodiscard]] Fault fault() const noexcept { return fault_; }
  [[nodiscard]] const std::string& reason() const noexcept { return reason_; }
  [[nodiscard]] std::int64_t since_ns() const noexcept { return since_ns_; }  // when the fault began
  // Since when nothing usable has come, of a channel that does not deliver: the stamp of its newest sample, or the
  // beginning of the fault if that was earlier. A fault may be told long after the newest sample: while the service is
  // stopped, nobody tells it.
  [[nodiscard]] std::int64_t missing_since_ns() const noexcept {
    return newest_ns_ < 0 ? since_ns_ : std::min(since_ns_, newest_ns_);
  }
  [[nodiscard]] std::int64_t heard_ns() const noexcept { return heard_ns_; }  // its newest sample's arrival; -1: never
  [[nodiscard]] double rate_hz() const noexcept { return rate_hz_; }          // over the last second or so

 private:
  Fault fault_ = Fault::silent;
  std::string reason_ = "nothing received yet";
  std::int64_t since_ns_;
  std::int64_t heard_ns_ = -1;
  std::int64_t newest_ns_ = -1;  // stamp of the newest sample; -1: none yet
  std::int64_t silence_ns_;      // nothing for so long is silence
  std::uint64_t samples_ = 0;
  double rate_hz_ = 0.0;
  std::int64_t rate_since_ns_;
  std::uint64_t rate_samples_ = 0;
};

}  // namespace dwell
