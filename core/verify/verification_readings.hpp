// Keeps the readings that count for a verification: those that the pipeline's intake accepts, channel by channel.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/stream/sample_history.hpp"
#include "core/verify/verification_stretch.hpp"

namespace dwell {

// Bound to one thread; allocates now and then. Memory: 16 bytes a reading.
class VerificationReadings {
 public:
  explicit VerificationReadings(std::size_t channels) : of_channel_(channels) {}

  // Takes the readings since the last call, if the history still holds them. O(new readings).
  void take(const SampleHistory& history) {
    for (next_ = std::max(next_, history.begin()); next_ < history.end(); ++next_) {
      const SampleHistory::Sample& sample = history[next_];
      ChannelReadings& channel = of_channel_[static_cast<std::size_t>(sample.channel)];
      channel.t_ns.push_back(sample.t_ns);
      channel.value.push_back(sample.value);
    }
  }
  // The readings in [from, until), one entry per channel.
  [[nodiscard]] std::vector<ChannelReadings> between(std::int64_t from_ns, std::int64_t until_ns) const {
    std::vector<ChannelReadings> out(of_channel_.size());
    for (std::size_t c = 0; c < out.size(); ++c) {
      const ChannelReadings& all = of_channel_[c];
      const auto at = [&all](std::int64_t t_ns) {
        return std::lower_bound(all.t_ns.begin(), all.t_ns.end(), t_ns) - all.t_ns.begin();
      };
      const auto first = at(from_ns), last = std::max(first, at(until_ns));
      out[c].t_ns.assign(all.t_ns.begin() + first, all.t_ns.begin() + last);
      out[c].value.assign(all.value.begin() + first, all.value.begin() + last);
    }
    return out;
  }
  [[nodiscard]] std::vector<ChannelReadings> since(std::int64_t t_ns) const { return between(t_ns, INT64_MAX); }

 private:
  std::vector<ChannelReadings> of_channel_;
  std::uint64_t next_ = 0;  // number in the history
};

}  // namespace dwell
