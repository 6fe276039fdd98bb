#pragma once

#include <cstdint>

namespace dwell {

// What a channel's readings look like, beside whether they come at all; the worst that applies.
enum class Condition : std::uint8_t {
  unheard,    // no reading yet
  ok,         // nothing is wrong with them
  gated,      // some are left out: far from the motion of the others
  overrange,  // the newest is beyond the channel's range, or an end code of its integer type
  held,       // the device refreshes them more slowly than they are read
  clipped,    // they pile up at an extreme
  stuck,      // one and the same for longer than the drive's motion allows
};
[[nodiscard]] const char* to_string(Condition condition) noexcept;  // "ok", "stuck", …

}  // namespace dwell
