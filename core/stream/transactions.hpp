// Finds out which channels are read in one transaction, and so share the uncertainty of their instants.
//
// A device answers one request with several readings: one transaction, one instant, one stamp. Two requests are two
// transactions, be they to two stations of a line or to two blocks of registers. Their turnarounds are independent. The
// stream itself shows the transactions: consecutive samples of one device with the same stamp and half width, three
// times in a row, belong to one. Two transactions of a device never begin at one instant. Their stamps agree to the
// nanosecond by chance only, once in some million. Samples whose stamp the driver replaced are not used.
//
// Pure, fixed memory after construction, bound to one thread. A sample costs a comparison; joining two channels for the
// first time costs O(channels).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"

namespace dwell {

class Transactions {
 public:
  explicit Transactions(const Rig& rig) {
    for (std::size_t i = 0; i < rig.channels.size(); ++i) {
      devices_.push_back(rig.channels[i].device);
      first_.push_back(static_cast<std::uint16_t>(i));
    }
    met_.resize(devices_.size());
  }

  // The next sample of the merged stream.
  void sample(const Record& sample) noexcept {
    if ((sample.flags & kStampReplaced) != 0) return;
    const bool together = sample.t_ns == last_.t_ns && sample.t_half_ns == last_.t_half_ns && heard_ &&
                          devices_[sample.channel] == devices_[last_.channel];
    Met& met = met_[sample.channel];
    if (!together || met.with != last_.channel) {
      met = {last_.channel, together ? 1 : 0};
    } else if (met.times < kTimes && ++met.times == kTimes) {
      unite(sample.channel, last_.channel);
    }
    last_ = {sample.t_ns, sample.t_half_ns, sample.channel};
    heard_ = true;
  }

  // The transaction of a channel, named by the lowest index of the channels that are read in it.
  [[nodiscard]] int of(int channel) const noexcept { return first_[static_cast<std::size_t>(channel)]; }

 private:
  void unite(std::size_t a, std::size_t b) noexcept {
    if (first_[a] == first_[b]) return;
    const std::uint16_t kept = first_[a] < first_[b] ? first_[a] : first_[b];
    const std::uint16_t given_up = first_[a] < first_[b] ? first_[b] : first_[a];
    for (std::uint16_t& first : first_)
      if (first == given_up) first = kept;
  }

  static constexpr int kTimes = 3;
  // The last channel with the same stamp, and how many times in a row it had it.
  struct Met {
    std::uint16_t with = 0;
    int times = 0;
  };
  std::vector<int> devices_;          // by channel
  std::vector<Met> met_;              // by channel
  std::vector<std::uint16_t> first_;  // by channel
  struct {
    std::int64_t t_ns = 0;
    std::uint32_t t_half_ns = 0;
    std::uint16_t channel = 0;
  } last_;  // of the sample before
  bool heard_ = false;
};

}  // namespace dwell
