#pragma once

#include <cstdint>
#include <string>

namespace dwell {

// Quality of a channel's readings; the worst condition that applies. It does not tell whether readings still arrive.
enum class Condition : std::uint8_t {
  unheard,    // no reading yet
  ok,         // no fault found
  gated,      // foreign readings: some were left out, or some that count bias the fit
  overrange,  // the newest reading is beyond the channel's range, or an end code of its integer type
  held,       // the device refreshes the register more slowly than it is read
  clipped,    // readings pile up at an extreme
  stuck,      // one and the same reading for longer than the drive's motion allows
};
[[nodiscard]] const char* to_string(Condition condition) noexcept;  // "ok", "stuck", …

// A channel whose readings are at fault.
struct ChannelFault {
  int channel = 0;   // index into Rig::channels
  std::string what;  // "reaction: clipped: …"
};

}  // namespace dwell
