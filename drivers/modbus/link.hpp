// One connection to a Modbus device or line, one transaction at a time, and never the answer to another request.
//
// TCP: every request carries an id of ours; answers with another id are late ones, thrown away. RTU answers carry no
// id: after a missing or damaged answer the line is left silent for `late`, emptied, and only then used again; what
// arrives still later cannot be told apart from the current answer. Bound to one thread; read() does not allocate.
#pragma once

#include <modbus/modbus.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "drivers/dwell_driver.hpp"
#include "drivers/modbus/connect.hpp"
#include "drivers/modbus/serial_lock.hpp"
#include "drivers/modbus/setup.hpp"

namespace dwell::modbus {

// How a transaction went.
struct Answer {
  dwell_fault fault = DWELL_FAULT_NONE;
  bool stopped = false;          // given up because of stop; nothing is known
  bool broken = false;           // the connection is of no more use: close it
  int exception = 0;             // the device's code, with DWELL_FAULT_EXCEPTION
  int error = 0;                 // errno, with DWELL_FAULT_DISCONNECTED
  unsigned late = 0;             // answers to earlier requests that were thrown away meanwhile
  std::int64_t sent_ns = 0;      // CLOCK_MONOTONIC_RAW: before the request left
  std::int64_t received_ns = 0;  // after the answer was complete
};

class Link {
 public:
  // Throws when libmodbus refuses the settings. Does not connect.
  explicit Link(const Setup& setup);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  // Connects, within about a second; empty: done, else why not.
  std::string open(const driver::Stop& stop);
  void close() noexcept;

  // Reads a block; registers: room for block.count. Blocks up to the timeout; RTU also while the line must be silent.
  Answer read(const Block& block, std::uint16_t* registers, const driver::Stop& stop) noexcept;

 private:
  enum class Receipt : std::uint8_t { frame, timeout, stopped, partial, bad_checksum, bad, lost };

  Answer read_tcp(const Block& block, std::uint16_t* registers, const driver::Stop& stop) noexcept;
  Answer read_rtu(const Block& block, std::uint16_t* registers, const driver::Stop& stop) noexcept;
  bool keep_silent(const driver::Stop& stop, Answer& answer) noexcept;
  Receipt receive(std::int64_t deadline_ns, const driver::Stop& stop, Answer& answer) noexcept;
  static void judge(const std::uint8_t* unit, std::size_t size, const Block& block, std::uint16_t* registers,
                    Answer& answer) noexcept;

  const Setup& setup_;
  std::unique_ptr<modbus_t, decltype(&modbus_free)> context_;
  std::optional<Connector> connector_;  // tcp
  SerialLock lock_;                     // rtu
  std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> frame_{};
  std::size_t frame_size_ = 0;
  std::uint16_t transaction_ = 0;  // tcp: id of the newest request
  std::int64_t free_ns_ = 0;       // rtu: CLOCK_MONOTONIC from which the line may be used
};

}  // namespace dwell::modbus
