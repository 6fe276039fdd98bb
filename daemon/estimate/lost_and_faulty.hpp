// What the stream is told of a device beside its samples and states: how many samples never reached it and why, and how
// often which fault occurred. So whoever has the stream can account for every sample.
//
// Counts that grow come in; records of what is new go out, at most four for a channel and one for a fault at each call.
// What finds no room is told with the next. Bound to one thread, real-time safe after construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/acquire/channel_counters.hpp"

namespace dwell {

class LostAndFaulty {
 public:
  // device: index into Rig::devices; channels: its own, as indices into Rig::channels.
  LostAndFaulty(std::uint16_t device, const std::vector<std::uint16_t>& channels) : device_(device) {
    for (const std::uint16_t channel : channels) channels_.push_back({channel, {}});
  }

  // What has become of the samples of its i-th channel since the beginning. enter(record): false where there is no
  // room.
  template <class Enter>
  void lost(std::size_t i, const Tally& tally, std::int64_t now_ns, Enter enter) {
    const auto tell_of = [&](Loss why, std::uint64_t count) {
      const auto flags = static_cast<std::uint8_t>(why);
      tell(Kind::loss, channels_[i].index, flags, count, channels_[i].told[flags - 1U], now_ns, enter);
    };
    tell_of(Loss::refused, tally.refused);
    tell_of(Loss::late, tally.late);
    tell_of(Loss::ahead, tally.ahead);
    tell_of(Loss::overflow, tally.overflow);
  }
  // How often the fault has occurred since the beginning.
  template <class Enter>
  void faulty(Fault fault, std::uint64_t occurrences, std::int64_t now_ns, Enter enter) {
    const auto kind = static_cast<std::uint8_t>(fault);
    tell(Kind::fault, device_, kind, occurrences, faults_[kind], now_ns, enter);
  }

 private:
  static constexpr std::size_t kLosses = 4;  // kinds of Loss, numbered from 1

  struct PerChannel {
    std::uint16_t index;
    std::array<std::uint64_t, kLosses> told;
  };

  template <class Enter>
  static void tell(Kind kind, std::uint16_t of, std::uint8_t flags, std::uint64_t count, std::uint64_t& told,
                   std::int64_t now_ns, Enter enter) {
    if (count == told) return;
    const Record record{
        .t_ns = now_ns, .value = static_cast<double>(count - told), .channel = of, .kind = kind, .flags = flags};
    if (enter(record)) told = count;
  }

  std::uint16_t device_;
  std::vector<PerChannel> channels_;
  std::array<std::uint64_t, kFaultCount> faults_{};
};

}  // namespace dwell
