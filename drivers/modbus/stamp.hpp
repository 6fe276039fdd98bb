// When a polled device sampled: within its turnaround, which is what remains of a transaction once the time that
// request and answer spend on the wire is taken off. Pure.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace dwell::modbus {

// A serial line's timing. A character: start bit, 8 data bits, parity bit if any, stop bits.
struct Wire {
  double baud = 0.0;
  double bits_per_character = 11.0;
  [[nodiscard]] constexpr std::int64_t time_ns(std::size_t bytes) const noexcept {
    return baud > 0.0 ? static_cast<std::int64_t>(static_cast<double>(bytes) * bits_per_character / baud * 1e9) : 0;
  }
};

struct Stamp {
  std::int64_t t_ns;
  std::uint32_t t_half_ns;
};

// sent: before the request's first byte left; received: after the answer's last byte came; the wire times are 0 for
// TCP. The instant lies between the request's end and the answer's begin: t is the middle, t_half half of that.
//
// A transaction shorter than its wire time comes from a baud rate slightly off, or from a virtual port that has none.
// Both bounds then stay within the transaction, and what lies between them, whichever comes first, is what is known.
[[nodiscard]] constexpr Stamp stamp(std::int64_t sent_ns, std::int64_t received_ns, std::int64_t request_wire_ns,
                                    std::int64_t answer_wire_ns) noexcept {
  const std::int64_t last_ns = std::max(sent_ns, received_ns);
  const std::int64_t a_ns = std::min(sent_ns + request_wire_ns, last_ns);
  const std::int64_t b_ns = std::max(received_ns - answer_wire_ns, sent_ns);
  const std::int64_t low_ns = std::min(a_ns, b_ns);
  const std::int64_t width_ns = std::max(a_ns, b_ns) - low_ns;
  const std::int64_t half_ns = std::min<std::int64_t>((width_ns + 1) / 2, std::numeric_limits<std::uint32_t>::max());
  return {low_ns + width_ns / 2, static_cast<std::uint32_t>(half_ns)};
}

}  // namespace dwell::modbus
