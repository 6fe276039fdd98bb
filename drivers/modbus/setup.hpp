// The modbus plugin's keys, and what they mean as plain values.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/dwell_driver.hpp"
#include "drivers/modbus/plan.hpp"
#include "drivers/modbus/stamp.hpp"

namespace dwell::modbus {

enum class Transport : std::uint8_t { tcp, rtu };

struct Setup {
  Transport transport = Transport::tcp;
  std::string host;  // tcp
  int port = 502;
  std::string serial;  // rtu
  int baud = 19200;
  char parity = 'E';  // N, E, O
  int stop_bits = 1;
  Wire wire;                    // rtu; tcp: takes no time
  std::int64_t gap_ns = 0;      // rtu: silence between two frames
  std::int64_t late_ns = 0;     // rtu: silence after a fault
  std::int64_t timeout_ns = 0;  // from the request's end; the answer's time on the wire comes on top
  double rate_hz = 100.0;       // polls per second
  std::vector<Block> blocks;

  // "127.0.0.1:502" or "/dev/ttyUSB0"
  [[nodiscard]] std::string address() const;
};

// Bytes of a transaction on a serial line.
inline constexpr std::size_t kRequestBytes = 8;
[[nodiscard]] constexpr std::size_t answer_bytes(unsigned registers) noexcept { return 5 + std::size_t{2} * registers; }

[[nodiscard]] std::span<const dwell_key> keys() noexcept;

// Takes the settings as they are, with defaults; use after check.
[[nodiscard]] Setup read_setup(const driver::Settings& settings);

// Polls of all blocks per second that the serial line can carry, answers without any turnaround; tcp: 0, not known.
[[nodiscard]] double most_rate_hz(const Setup& setup) noexcept;

// How old a reading may be when it is delivered: answered at the end of its timeout, and its time on the wire.
[[nodiscard]] std::int64_t greatest_age_ns(const Setup& setup) noexcept;

// Reports everything that the key schema cannot see.
void check_setup(const driver::Settings& settings, driver::Report& report);

}  // namespace dwell::modbus
