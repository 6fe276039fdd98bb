// Turns the faults, losses and channel states of the stream into events, each one line for people.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// By Rig::channels and Rig::devices.
struct StreamNames {
  std::vector<std::string> channels, devices;
};

// Why samples were lost, for people: "the merger was full".
[[nodiscard]] const char* loss_text(Loss loss) noexcept;

// Bound to one thread. All repetitions of a fault or loss between two calls of drain() make one event, with their
// count. Channel states beyond 1000 between two calls make one event too: bounds what a broken stream takes.
class StreamEvents {
 public:
  // `position`: of the record in its run.
  void take(const Record& record, std::uint64_t position);
  // The events since the last call, in the order of their positions. utc: of an instant of the stream.
  [[nodiscard]] std::vector<StoredEvent> drain(const StreamNames& names,
                                               const std::function<std::string(std::int64_t t_ns)>& utc);

 private:
  struct Count {
    std::uint64_t position = 0;  // of the first
    std::int64_t t_ns = 0;       // likewise
    std::uint64_t times = 0;
  };
  using Key = std::tuple<Kind, std::uint16_t, std::uint8_t>;  // kind, channel or device, fault or loss

  std::map<Key, Count> counts_;
  std::vector<std::pair<std::uint64_t, Record>> states_;  // with their positions
};

}  // namespace dwell::record
