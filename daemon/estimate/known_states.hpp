// Keeps what a new pipeline needs to know of the stream so far: the newest state of each channel, and the level of the
// interlock. A pipeline may be born in the middle of the stream.
//
// Its records repeat what older pipelines know already, so they change nothing for these.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/stream/record.hpp"

namespace dwell {

// Bound to one thread. Real-time safe after construction.
class KnownStates {
 public:
  explicit KnownStates(std::size_t channels) : faults_(channels) {}

  // The next record of the stream.
  void take(const Record& record) noexcept {
    if (record.kind == Kind::channel_state && record.channel < faults_.size()) faults_[record.channel] = record.flags;
    if (record.kind == Kind::edge && record.channel == static_cast<std::uint16_t>(Line::interlock))
      interlock_ = {true, record.value};
  }

  // Calls each(record) for every known state, as a record with the instant t_ns.
  template <class Each>
  void tell(std::int64_t t_ns, Each each) const {
    for (std::size_t c = 0; c < faults_.size(); ++c)
      if (faults_[c])
        each(Record{
            .t_ns = t_ns, .channel = static_cast<std::uint16_t>(c), .kind = Kind::channel_state, .flags = *faults_[c]});
    if (interlock_.known)
      each(Record{.t_ns = t_ns,
                  .value = interlock_.level,
                  .channel = static_cast<std::uint16_t>(Line::interlock),
                  .kind = Kind::edge});
  }

 private:
  std::vector<std::optional<std::uint8_t>> faults_;  // by Rig::channels: a Fault; none: no state has come yet
  struct {
    bool known = false;
    double level = 0.0;
  } interlock_;
};

}  // namespace dwell
