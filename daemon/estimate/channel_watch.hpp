// Whether each channel delivers, why not, and how fast: what the drivers say, what their silence says, told apart by
// the instants at which it was said. Virtual time; bound to the estimation thread. No allocation per sample.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/stream/record.hpp"

namespace dwell {

class ChannelWatch {
 public:
  struct Channel {
    Fault fault = Fault::silent;
    std::string reason = "nothing received yet";
    std::int64_t since_ns = 0;    // when `fault` began
    std::int64_t heard_ns = -1;   // when its newest sample was taken in; -1: never
    std::int64_t silence_ns = 0;  // nothing for so long is silence
    std::uint64_t samples = 0;    // taken in
    double rate_hz = 0.0;
    std::int64_t rate_since_ns = 0;
    std::uint64_t rate_samples = 0;
  };

  // nominal_rate_hz: per channel, 0 where not known. A channel that says nothing for 20 nominal intervals, at least
  // 1 s, is silent.
  ChannelWatch(const std::vector<double>& nominal_rate_hz, std::int64_t now_ns);

  // A sample, stamped t_ns, taken in at now_ns. true: the channel was stale and delivers again, for a sample is proof
  // of it; not if the sample is older than the fault.
  bool sample(std::size_t channel, std::int64_t t_ns, std::int64_t now_ns) noexcept;

  // Something came of it, whatever it was worth.
  void heard(std::size_t channel, std::int64_t now_ns) noexcept {
    channels_[channel].heard_ns = now_ns;
    ++channels_[channel].samples;
  }

  // The driver says how it stands. true: this is new.
  bool said(std::size_t channel, std::int64_t t_ns, Fault fault, const char* reason);

  // true: the channel has just fallen silent.
  bool fell_silent(std::size_t channel, std::int64_t now_ns);

  // Brings rate_hz up to date; call a few times a second.
  void measure_rates(std::int64_t now_ns) noexcept;

  [[nodiscard]] const Channel& operator[](std::size_t channel) const noexcept { return channels_[channel]; }
  [[nodiscard]] std::size_t size() const noexcept { return channels_.size(); }

 private:
  std::vector<Channel> channels_;
};

}  // namespace dwell
