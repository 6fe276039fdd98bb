#include "daemon/acquire/hold_back.hpp"

#include <algorithm>

#include "core/stream/scan_clocks.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kShortest_ns = 100'000'000;
// Beyond the slowest answer that the shipped drivers allow (5 s and its time on the wire). A longer wait would delay
// every result; halved, the slowest lines would lose all they send.
constexpr std::int64_t kLongest_ns = 10'000'000'000;
// By which the threads between device and merger may be late: five turns of the estimation.
constexpr std::int64_t kStall_ns = 50'000'000;

}  // namespace

std::int64_t hold_back_ns(const config::RigFile& file) {
  std::int64_t longest_ns = kShortest_ns;
  for (const Device& device : file.rig.devices)
    if (device.clock == Clock::device) longest_ns = std::max(longest_ns, ScanClocks::kHoldBack_ns);
  for (const config::DeviceSettings& device : file.devices)
    longest_ns = std::max(longest_ns, std::min(device.age_ns, kLongest_ns) + kStall_ns);
  return std::min(longest_ns, kLongest_ns);
}

}  // namespace dwell
