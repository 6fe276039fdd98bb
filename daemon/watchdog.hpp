// Whether the service works, for systemd's watchdog: every thread of its own has turned within its bound, and no ring
// holds samples that nobody takes. A driver that hangs is the fault of its device (DeviceIntake), no reason to restart.
// Pure: the caller brings the instants; never fed by a timer alone. Bound to one thread.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace dwell {

struct WatchedThread {
  std::string name;
  std::int64_t last_turn_ns = 0;  // CLOCK_MONOTONIC_RAW
  std::int64_t bound_ns = 0;      // it must have turned within this
  bool ours = true;               // false: a driver's; shown, but the service works without it

  [[nodiscard]] std::int64_t still_ns(std::int64_t now_ns) const noexcept { return now_ns - last_turn_ns; }
  [[nodiscard]] bool turns(std::int64_t now_ns) const noexcept { return still_ns(now_ns) <= bound_ns; }
};

struct WatchedRing {
  std::string name;
  std::uint64_t entered = 0;  // read before `left`
  std::uint64_t left = 0;
};

class Watchdog {
 public:
  // A ring whose samples nobody has touched for so long is stuck.
  static constexpr std::int64_t kRingBound_ns = 2'000'000'000;

  // Empty: all is well. Else what is not, in words.
  [[nodiscard]] std::string judge(std::int64_t now_ns, const std::vector<WatchedThread>& threads,
                                  const std::vector<WatchedRing>& rings);

 private:
  struct Progress {
    std::uint64_t left = 0;
    std::int64_t since_ns = 0;  // when it moved last, or was last found empty
  };
  std::unordered_map<std::string, Progress> rings_;
};

}  // namespace dwell
